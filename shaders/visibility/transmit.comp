// SPDX-License-Identifier: MIT
// The colour of what arrives of a light through translucent surfaces: visibility times the mean transmittance of the points of the light
// that are seen. The visibility is taken as it is, exact where it comes from `cover`; the colour is a ratio of sums over the same
// rays, sum(open T) / sum(open), so that where T is the same for all of a light there is no noise at all. Open is asked only where
// a part of the light is hidden and T differs: elsewhere it cancels. One workgroup per tile. docs/lights.md.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#include "visibility/shadow_ray.glsl"
#include "common/tiles.glsl"
#include "visibility/tile_share.glsl"
#include "visibility/transmittance.glsl"

const uint MOST_RAYS = 32u;
shared uint ray_transmittance[32u * MOST_RAYS];  // by the pixel's number: of its rays, packed
shared uint open_rays[32];                       // bit k: ray k arrives

uint ray_count() { return HAS_BLUE_NOISE ? min(RAYS_PER_PIXEL, MOST_RAYS) : 1u; }

ivec2 pixel_numbered(ivec2 tile, uint number) { return tile * TILE + pixel_of_lane(int(number)); }

// The axis and the tangent of a cone from a pixel that holds its light; false: there is none.
bool light_cone(vec3 origin, out vec3 axis, out float spread) {
    if (!HAS_LIGHT) {
        axis = sun.to_sun;
        spread = tan(sun.angular_radius);
        return true;
    }
    const vec3 way = light.centre + scene.camera_from_origin - origin;
    const float bound = light_bound_m(), rest = dot(way, way) - bound * bound;
    axis = normalize(way);
    spread = bound * inversesqrt(max(rest, 1e-30));
    return rest > 0.0;
}

// Of a pixel that sees some of its light: whether any of that may be coloured.
bool may_be_coloured(ivec2 p, bool wanted) {
    const vec3 n = decode_receiver_normal(imageLoad(receiver_normal, p).xy);
    vec3 origin, axis;
    float spread;
    if (HAS_LIGHT) origin = ray_origin_to(ray_start(p, n), n, light.centre + scene.camera_from_origin);
    else origin = ray_origin(p, n, sun.to_sun);
    const bool narrow = light_cone(origin, axis, spread);
    return wanted && (!narrow || may_meet_translucents(cone_slabs(axis, spread, 0.0), origin, axis, wanted));
}

// Those of the share that may be coloured; the others get their visibility as it is.
uint coloured_pixels(TileShare share, ivec2 tile) {
    uint coloured = 0u;
    for (uint first = share.first; first < share.end; first += share.lanes) {
        const uint number = first + share.lane;
        const bool inside = number < share.end && (share.wanted >> number & 1u) != 0u;
        const ivec2 p = inside ? pixel_numbered(tile, number) : tile * TILE;
        const float seen = texelFetch(visibility, p, 0).x;
        const bool asked = inside && seen > 0.0 && imageLoad(view_depth, p).x > 0.0;
        const bool found = may_be_coloured(p, asked);
        if (found) coloured |= 1u << number;
        if (inside && !found) imageStore(transmittance, p, vec4(vec3(seen), 1.0));
    }
    return subgroupOr(coloured);
}

// Those of whose rays it matters which arrive.
uint mixed_pixels(TileShare share, ivec2 tile, uint rays) {
    uint mixed = 0u;
    for (uint first = share.first; first < share.end; first += share.lanes) {
        const uint number = first + share.lane;
        if (number >= share.end || (share.wanted >> number & 1u) == 0u) continue;
        open_rays[number] = ~0u;
        bool alike = true;
        for (uint k = 1u; k < rays; ++k)
            if (ray_transmittance[number * MOST_RAYS + k] != ray_transmittance[number * MOST_RAYS]) alike = false;
        if (alike || texelFetch(visibility, pixel_numbered(tile, number), 0).x >= 1.0) continue;
        open_rays[number] = 0u;
        mixed |= 1u << number;
    }
    return subgroupOr(mixed);
}

vec3 mean_transmittance(uint number, uint rays) {
    const uint open = open_rays[number] == 0u ? ~0u : open_rays[number];  // none arrives: all are as likely
    vec3 sum = vec3(0.0);
    float count = 0.0;
    for (uint k = 0u; k < rays; ++k)
        if ((open >> k & 1u) != 0u) {
            sum += unpack_transmittance(ray_transmittance[number * MOST_RAYS + k]);
            count += 1.0;
        }
    return sum / count;
}

void main() {
    const ivec2 tile = ivec2(gl_WorkGroupID.xy);
    const uint rays = ray_count();
    TileShare share = tile_share(inside_mask(tile));
    share.wanted = coloured_pixels(share, tile);
    const uint coloured_rays = uint(bitCount(share.wanted)) * rays;
    for (uint first = 0u; first < coloured_rays; first += share.lanes) {
        const uint index = first + share.lane;
        if (index < coloured_rays) {
            const uint number = wanted_number(share, index / rays), k = index % rays;  // a pixel's rays lie side by side
            const ShadowRay ray = shadow_ray(pixel_numbered(tile, number), k, rays);
            ray_transmittance[number * MOST_RAYS + k] =
                pack_transmittance(transmittance_along(ray.origin, ray.direction, HAS_LIGHT ? ray.t_max : SUN_IS_AT_M));
        }
    }
    subgroupBarrier();
    TileShare mixed = share;
    mixed.wanted = mixed_pixels(share, tile, rays);
    subgroupBarrier();
    const uint opaque_rays = uint(bitCount(mixed.wanted)) * rays;
    for (uint first = 0u; first < opaque_rays; first += share.lanes) {
        const uint index = first + share.lane;
        if (index < opaque_rays) {
            const uint number = wanted_number(mixed, index / rays), k = index % rays;
            const ShadowRay ray = shadow_ray(pixel_numbered(tile, number), k, rays);
            if (!ray.into_surface && !occluded(ray.origin, ray.direction, nearest_hit_m(0.0), HAS_LIGHT ? ray.t_max : SUN_IS_AT_M))
                atomicOr(open_rays[number], 1u << k);
        }
    }
    subgroupBarrier();
    for (uint number = share.first + share.lane; number < share.end; number += share.lanes) {
        if ((share.wanted >> number & 1u) == 0u) continue;
        const ivec2 p = pixel_numbered(tile, number);
        imageStore(transmittance, p, vec4(texelFetch(visibility, p, 0).x * mean_transmittance(number, rays), 1.0));
    }
    count_coloured(subgroupElect() ? uint(bitCount(share.wanted)) : 0u);
    count_rays(subgroupElect() ? coloured_rays + opaque_rays : 0u);
}
