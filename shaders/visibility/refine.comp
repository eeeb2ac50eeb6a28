// SPDX-License-Identifier: MIT
// Further shadow rays where pixels are worth them: together with the first, which `trace` has cast, as many as a record says, to
// points that lie evenly over the sun. One workgroup per record.
#extension GL_KHR_shader_subgroup_shuffle : require
#include "node.glsl"
#include "common/camera.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#include "visibility/shadow_ray.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#include "visibility/tile_share.glsl"
#define SEVERAL_RAYS 1
#include "visibility/rays_together.glsl"

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
        const bool own = first + share.lane < ray_count;
        const uint index = own ? first + share.lane : first;
        const uint number = wanted_number(share, index / further), k = index % further;  // a pixel's rays lie side by side
        const ShadowRay ray = shadow_ray(tile * TILE + pixel_of_lane(int(number)), k + 1u, rays);
        float unread = 0.0;
        const bool met = occluded_beside(ray.origin, ray.beyond_edge_m, ray.direction, t_min, HAS_LIGHT ? min(t_max, ray.t_max) : t_max, own && !ray.into_surface, unread);
        if (met || own && ray.into_surface) atomicOr(blocked[number], 1u << k);
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
            if (hit != 0u && hit != rays) store_fraction(p, vec4(float(rays - hit) / float(rays)));
#endif
        }
    count_rays(subgroupElect() ? ray_count : 0u);
}
