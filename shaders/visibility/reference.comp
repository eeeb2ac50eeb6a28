// SPDX-License-Identifier: MIT
// True visibility by many rays of the kind that trace casts: same origins, same cone, stratified over the sun's disc; the
// receiver's own plane hides what is below it, which an origin above the surface would let pass at the surface's end. The
// host repeats a frozen frame until all rays are cast; counts are integers, so no sum loses anything.
//   stage 0: a few rays for every receiver;
//   stage 1: where these disagree within 5x5 pixels, start anew with the first of many rays; elsewhere keep what is known;
//   stage 2: go on.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/hash.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#include "common/sun_sample.glsl"
#if BACKEND == BACKEND_RAY_QUERY
#include "common/ray_query.glsl"
#else
#include "common/bvh.glsl"
#endif

const float WHOLE_RAY_M = 1e30;  // as classify gives it
const uint PROBE = 0u, START = 1u, CONTINUE = 2u;
const int REACH = 2;

bool is_receiver(ivec2 p) { return inside_frame(p) && imageLoad(view_depth, p).x > 0.0; }

// Whether the few rays of p and its neighbours saw both light and shadow.
bool disagrees(ivec2 p) {
    bool any_lit = false, any_dark = false;
    for (int y = -REACH; y <= REACH; ++y)
        for (int x = -REACH; x <= REACH; ++x) {
            const ivec2 q = p + ivec2(x, y);
            if (!is_receiver(q)) continue;
            const uvec4 known = imageLoad(counts_prev, q);
            any_lit = any_lit || known.x > 0u;
            any_dark = any_dark || known.x < known.y;
        }
    return any_lit && any_dark;
}

// A point of stratum `index` of side x side, shifted inside it by a hash of everything.
vec2 stratified(ivec2 p, uint index) {
    const uint first = noise_hash(uint(p.x) + noise_hash(uint(p.y) + noise_hash(index + noise_hash(params.seed + params.stage * 3u))));
    const vec2 within = noise_unit(uvec2(first, noise_hash(first)));
    return (vec2(index % params.side, index / params.side) + within) / float(params.side);
}

uint count_lit_rays(ivec2 p, uint first, uint count) {
    const vec3 n = decode_receiver_normal(imageLoad(receiver_normal, p).xy);
    const vec3 origin = shadow_ray_origin(p, n);
    uint lit = 0u;
    for (uint i = 0u; i < count; ++i) {
        const vec3 direction = sun_direction(sun.to_sun, sun.angular_radius, stratified(p, first + i));
        if (!points_into_surface(n, direction)) lit += uint(!occluded(origin, direction, 0.0, WHOLE_RAY_M));
    }
    return lit;
}

void for_pixel(ivec2 p) {
    const float z = imageLoad(view_depth, p).x;
    uvec4 known = uvec4(0u);  // lit rays, all rays, whether this pixel wants many
    if (z > 0.0) {
        if (params.stage != PROBE) known = imageLoad(counts_prev, p);
        if (params.stage == START && disagrees(p)) known = uvec4(0u, 0u, 1u, 0u);
        if (params.stage == PROBE || known.z != 0u)
            known.xy += uvec2(count_lit_rays(p, params.first, params.count), params.count);
    }
    imageStore(counts, p, known);
}

void main() { for_each_pixel(); }
