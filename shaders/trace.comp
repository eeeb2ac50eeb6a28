// SPDX-License-Identifier: MIT
// One shadow ray per undecided pixel: one workgroup per listed tile, one lane per pixel. Lanes are dealt out in blocks
// of 4x2 pixels, so that the 8 lanes of a software device's subgroup walk the tree together.
// Sampling: a point of the sun's disc per pixel and frame; see common/sun_sample.glsl and common/blue_noise.glsl. A sun
// that is a point takes no noise.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/ray_origin.glsl"
#if HAS_BLUE_NOISE
#include "common/sun_point.glsl"
#endif
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#if HAS_BLOCKERS
#include "common/blockers.glsl"
#endif
#if BACKEND == BACKEND_RAY_QUERY
#include "common/ray_query.glsl"
#else
#include "common/bvh.glsl"
#endif

const float PUBLISHED_OFFSET_M = 1e-4;  // Hybrid Shadows sample: both constants are absolute lengths
const float PUBLISHED_T_MIN_M = 4e-2;

float offset_m(ivec2 p, float z, vec3 n, vec3 relative, vec3 in_scene) {
    if (ORIGIN == ORIGIN_PUBLISHED) return PUBLISHED_OFFSET_M;
    return robust_offset_m(p, z, n, relative, in_scene);
}

vec3 ray_direction(ivec2 p) {
#if HAS_BLUE_NOISE
    if (SAMPLING == SAMPLING_PUBLISHED)
        return sun_direction_published(sun.to_sun, sun.angular_radius,
                                       noise_published(p, frame.frame_index, params.seed));
    return sun_direction_through(sun.to_sun, sun.angular_radius, sun_point(p, frame.frame_index, params.seed));
#else
    return sun.to_sun;
#endif
}

bool hits_something(ivec2 p, float t_min, float t_max, inout float t_hit) {
    const float z = imageLoad(view_depth, p).x;
    const vec3 relative = position(p, z);
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    const vec3 in_scene = relative + scene.camera_from_origin;
    const vec3 origin = in_scene + n * offset_m(p, z, n, relative, in_scene);
    if (ORIGIN == ORIGIN_PUBLISHED) t_min = max(t_min, PUBLISHED_T_MIN_M);
    return occluded_at(origin, ray_direction(p), t_min, t_max, t_hit);
}

void main() {
    uvec4 record;
    if (!listed_tile(record)) return;  // the whole workgroup
    const int lane = int(gl_LocalInvocationIndex);
    const ivec2 in_tile = ivec2((lane >> 3 & 1) * 4 + (lane & 3), (lane >> 4) * 2 + (lane >> 2 & 1));
    const ivec2 tile = tile_of(record);
    const uint bit = pixel_bit(in_tile);
    const bool wanted = (record.y & bit) != 0u;

    uint hit = 0u;
    float t_hit = 0.0;
    if (wanted && hits_something(tile * TILE + in_tile, uintBitsToFloat(record.z), uintBitsToFloat(record.w), t_hit))
        hit = bit;
    const uint word = subgroupOr(hit);
    if (subgroupElect() && word != 0u) atomicOr(hits[tile_index(tile)], word);
#if HAS_BLOCKERS
    add_blockers(tile_index(tile), hit != 0u, t_hit);
#endif
    count_rays(wanted ? 1u : 0u);
}
