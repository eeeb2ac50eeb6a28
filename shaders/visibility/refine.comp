// SPDX-License-Identifier: MIT
// Further shadow rays where pixels are worth them: together with the first, which `trace` has cast, as many as a record says, to
// points that lie evenly over the sun. One workgroup per record.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#include "visibility/shadow_ray.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#include "visibility/tile_share.glsl"
#if BACKEND == BACKEND_RAY_QUERY
#include "common/ray_query.glsl"
#else
#include "common/bvh.glsl"
#endif

shared uint blocked[32];  // of the pixel with this number: bit k - 1 is ray k

void main() {
    uvec4 record;
    if (!listed_tile(record)) return;  // the whole workgroup
    const ivec2 tile = tile_of(record);
    const float t_min = nearest_hit_m(uintBitsToFloat(record.z)), t_max = uintBitsToFloat(record.w);
    const TileShare share = tile_share(record.y);
    const uint rays = rays_of(record), further = rays - 1u, ray_count = uint(bitCount(share.wanted)) * further;
    for (uint number = share.first + share.lane; number < share.end; number += share.lanes) blocked[number] = 0u;
    subgroup_barrier();
    for (uint first = 0u; first < ray_count; first += share.lanes) {
        const uint index = first + share.lane;
        if (index < ray_count) {
            const uint number = wanted_number(share, index / further), k = index % further;  // a pixel's rays lie side by side
            const ShadowRay ray = shadow_ray(tile * TILE + pixel_of_lane(int(number)), k + 1u, rays);
            if (ray.into_surface || occluded(ray.origin, ray.direction, t_min, HAS_LIGHT ? min(t_max, ray.t_max) : t_max)) atomicOr(blocked[number], 1u << k);
        }
    }
    subgroup_barrier();
    const uint first_hits = hits[tile_index(tile)];
    for (uint number = share.first + share.lane; number < share.end; number += share.lanes)
        if ((share.wanted >> number & 1u) != 0u) {
            const ivec2 p = tile * TILE + pixel_of_lane(int(number));
            const uint hit = uint(bitCount(blocked[number])) + ((first_hits & pixel_bit(p)) != 0u ? 1u : 0u);
#if HAS_RAY_BITS
            ray_bits[uint(p.y) * frame.size.x + uint(p.x)] = blocked[number] | 1u << further;
#endif
#if HAS_FRACTION
            if (hit != 0u && hit != rays) imageStore(fraction, p, vec4(float(rays - hit) / float(rays)));
#endif
        }
    count_rays(subgroupElect() ? ray_count : 0u);
}
