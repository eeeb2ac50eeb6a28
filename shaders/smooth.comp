// SPDX-License-Identifier: MIT
// One pass of an edge-avoiding a-trous filter (Dammertz et al. 2010): 3x3 taps at distance STEP of pixels on the same
// surface. A tap counts by how its visibility differs from the centre's, in units of the centre's tolerance: that is
// what is not known about the centre, so a converged pixel and a hard edge keep what they have, and next to them an
// uncertain pixel learns. Each pass narrows the tolerance by what its average has gained.
// Weights are rational functions: no exponential per tap.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/tiles.glsl"

const float SIDE = 2.0 / 3.0;         // kernel: 2/3, 1, 2/3 per axis
const float MIN_TOLERANCE = 1.0 / 4096.0;  // less cannot change what is stored

// 1 at 0, 1/4 at 1, falls with the fourth power.
float bell(float squared) {
    const float w = 1.0 / (1.0 + squared);
    return w * w;
}

// Distances to the centre's plane of points behind neighbouring pixels: (n . position) is bilinear in pixel and depth.
struct Plane {
    vec3 origin, ray;  // n . origin of the view ray and n . its direction: value at p, and change per pixel in x and y
    float at;          // n . position of p
};

Plane plane_through(ivec2 p, float z, vec3 n) {
    const vec2 uv = pixel_uv(p) - frame.jitter, px = 1.0 / vec2(frame.size);
    const vec3 o = position_at(uv, 0.0), ox = position_at(uv + vec2(px.x, 0.0), 0.0),
               oy = position_at(uv + vec2(0.0, px.y), 0.0);
    const vec3 r = position_at(uv, 1.0) - o, rx = position_at(uv + vec2(px.x, 0.0), 1.0) - ox,
               ry = position_at(uv + vec2(0.0, px.y), 1.0) - oy;
    Plane plane;
    plane.origin = vec3(dot(n, o), dot(n, ox - o), dot(n, oy - o));
    plane.ray = vec3(dot(n, r), dot(n, rx - r), dot(n, ry - r));
    plane.at = plane.origin.x + z * plane.ray.x;
    return plane;
}

float distance_m(Plane plane, vec2 offset_px, float z) {
    const vec3 step = vec3(1.0, offset_px);
    return dot(plane.origin, step) + z * dot(plane.ray, step) - plane.at;
}

vec2 smoothed_at(ivec2 p, float z, vec2 centre) {
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    const Plane plane = plane_through(p, z, n);
    const float per_tolerance = 1.0 / centre.y;
    const float per_length = 1.0 / (float(STEP) * pixel_span_m(z));

    vec2 sum = vec2(centre.x, 1.0);
    float weights = 1.0;
    const ivec2 last = ivec2(frame.size) - 1;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            if (x == 0 && y == 0) continue;
            const ivec2 offset = STEP * ivec2(x, y), q = clamp(p + offset, ivec2(0), last);
            const float kernel = q != p + offset ? 0.0 : (x == 0 ? 1.0 : SIDE) * (y == 0 ? 1.0 : SIDE);
            const float z_tap = imageLoad(view_depth, q).x;
            const float tap = imageLoad(signal, q).x;
            const vec3 n_tap = decode_normal(imageLoad(guide_normal, q));  // zero: no receiver
            const float by_value = (tap - centre.x) * per_tolerance;
            const float by_depth = distance_m(plane, vec2(offset), z_tap) * per_length;
            const float weight = kernel * bell(by_value * by_value) * bell(by_depth * by_depth) *
                                 normal_weight(n, 1.0, n_tap);
            sum += vec2(weight * tap, weight * weight);
            weights += weight;
        }
    return vec2(sum.x / weights, centre.y * sqrt(sum.y) / weights);
}

void for_pixel(ivec2 p) {
    const uint state = tile_meta[block_index(p / BLOCK)];
    vec2 s = vec2(1.0, 0.0);
    if (state != BLOCK_LIT) {  // in a shadowed block it is 0 for receivers and 1 for the rest
        s = imageLoad(signal, p).xy;
        if (state == BLOCK_WORK && s.y > MIN_TOLERANCE) s = smoothed_at(p, imageLoad(view_depth, p).x, s);
    }
    imageStore(smoothed, p, vec4(s, 0.0, 0.0));
}

void main() { for_each_pixel(); }
