// SPDX-License-Identifier: MIT
// Shadow rays of undecided pixels: one workgroup per listed tile.
#extension GL_KHR_shader_subgroup_shuffle : require
#include "node.glsl"
#if HAS_FRACTION
const uint RAYS = RAYS_PER_PIXEL;
#else
const uint RAYS = 1u;
#endif
#include "common/camera.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#include "visibility/shadow_ray.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#include "visibility/tile_share.glsl"
#if HAS_FRACTION
#include "visibility/lit_share.glsl"
#endif
#if HAS_BLOCKERS
#include "common/rounded.glsl"
#include "common/blockers.glsl"
#endif
#define SEVERAL_RAYS HAS_FRACTION
#include "visibility/rays_together.glsl"

void main() {
    uvec4 record;
    if (!listed_tile(record)) return;  // the whole workgroup
    const ivec2 tile = tile_of(record);
    const float t_min = nearest_hit_m(uintBitsToFloat(record.z)), t_max = uintBitsToFloat(record.w);
    const TileShare share = tile_share(record.y);
    const uint ray_count = uint(bitCount(share.wanted)) * RAYS;
#if HAS_BLOCKERS
    BlockerSums sums = BlockerSums(0u, 0u, 0u);
#endif
#if HAS_FRACTION
    clear_shares(share);
#endif
    uint blocked = 0u;  // pixels whose first ray hits
    for (uint first = 0u; first < ray_count; first += share.lanes) {
        const bool own = first + share.lane < ray_count;
        const uint index = own ? first + share.lane : first;
        const uint number = wanted_number(share, index / RAYS), k = index % RAYS;  // a pixel's rays lie side by side
        const ShadowRay ray = shadow_ray(tile * TILE + pixel_of_lane(int(number)), k, RAYS);
        float t = 0.0;
        const bool met = occluded_beside(ray.origin, ray.beyond_edge_m, ray.direction, t_min, HAS_LIGHT ? min(t_max, ray.t_max) : t_max, own && !ray.into_surface, t);
#if HAS_BLOCKERS
        if (met && k == 0u) add_blocker(sums, HAS_LIGHT ? way_to_blocker(t, ray.t_plane) : t);
#endif
        const bool hit = own && ray.into_surface || met;
        if (hit && k == 0u) blocked |= 1u << number;
#if HAS_FRACTION
        if (own && !hit) count_as_lit(number);
#endif
    }
    blocked = subgroupOr(blocked);
    if (subgroupElect() && blocked != 0u) atomicOr(hits[tile_index(tile)], lanes_of_pixels(blocked));
#if HAS_FRACTION
    store_shares(share, tile);
#endif
#if HAS_BLOCKERS
    store_blockers(tile_index(tile), sums);
#endif
    count_rays(subgroupElect() ? ray_count : 0u);
}
