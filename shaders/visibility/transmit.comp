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
const bool HAS_TRANSLUCENTS = true;
#include "visibility/transmittance.glsl"
#include "visibility/coloured_light.glsl"

// By the pixel's number, of all its rays, and from 32 on of those that arrive: sums of their transmittances, in steps, and the number
// of rays. Two sums to a word, which 64 rays fill.
shared uint red_and_green[64], blue_and_count[64];
shared uint least[32], most[32];  // of all rays, packed: the same where T is

uint ray_count() { return HAS_BLUE_NOISE ? RAYS_PER_PIXEL : 1u; }

void add_ray(uint slot, uint steps) {
    atomicAdd(red_and_green[slot], (steps & 1023u) | (steps & 1023u << 10) << 6);
    atomicAdd(blue_and_count[slot], steps >> 20 | 1u << 16);
}

ivec2 pixel_numbered(ivec2 tile, uint number) { return tile * TILE + pixel_of_lane(int(number)); }

// Of a pixel that sees some of its light: whether any of that may be coloured. Whom a light that is near does not reach has no shadow of it.
bool may_be_coloured(ivec2 p, bool wanted) {
    const vec3 n = decode_receiver_normal(texelFetch(receiver_normal, p, 0).xy);
    if (HAS_LIGHT) {
        const RayStart start = ray_start(p, n);
        const vec3 centre = light.centre + scene.camera_from_origin;
        return near_light_may_be_coloured(shadow_origin_to(start, n, centre), wanted && light_reaches(start.off_surface - centre));
    }
    return may_meet_translucents(cone_slabs(sun.to_sun, tan(sun.angular_radius), 0.0), shadow_origin(ray_start(p, n), n, sun.to_sun), sun.to_sun, wanted);
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
        if (inside && !found) store_transmittance(p, vec4(vec3(seen), 1.0));
    }
    return subgroupOr(coloured);
}

void clear_rays(TileShare share) {
    for (uint number = share.first + share.lane; number < share.end; number += share.lanes) {
        red_and_green[number] = red_and_green[32u + number] = 0u;
        blue_and_count[number] = blue_and_count[32u + number] = 0u;
        least[number] = ~0u;
        most[number] = 0u;
    }
    subgroup_barrier();
}

// Those of whose rays it matters which arrive.
uint mixed_pixels(TileShare share, ivec2 tile) {
    uint mixed = 0u;
    for (uint number = share.first + share.lane; number < share.end; number += share.lanes) {
        const bool differs = (share.wanted >> number & 1u) != 0u && least[number] != most[number];
        if (differs && texelFetch(visibility, pixel_numbered(tile, number), 0).x < 1.0) mixed |= 1u << number;
    }
    return subgroupOr(mixed);
}

// Of the rays that arrive; where none does all are as likely.
vec3 mean_transmittance(uint number) {
    const uint slot = blue_and_count[32u + number] != 0u ? 32u + number : number;
    const vec3 sum = vec3(red_and_green[slot] & 0xffffu, red_and_green[slot] >> 16, blue_and_count[slot] & 0xffffu);
    return sum / (float(blue_and_count[slot] >> 16) * TRANSMITTANCE_STEPS);
}

// Casts the rays of the share's pixels; only those that arrive, and counted as such, where it matters. How many.
uint cast_rays(TileShare share, ivec2 tile, bool arriving) {
    const uint rays = ray_count(), count = uint(bitCount(share.wanted)) * rays;
    for (uint first = 0u; first < count; first += share.lanes) {
        const uint index = first + share.lane;
        if (index >= count) continue;
        const uint number = wanted_number(share, index / rays);  // a pixel's rays lie side by side
        const ShadowRay ray = shadow_ray(pixel_numbered(tile, number), index % rays, rays);
        const float t_max = HAS_LIGHT ? ray.t_max : SUN_IS_AT_M;
        float unread = 0.0;
        if (arriving && (ray.into_surface || occluded_from(ray.origin, ray.beyond_edge_m, ray.direction, nearest_hit_m(0.0), t_max, unread))) continue;
        const uint steps = pack_transmittance(transmittance_along(ray.origin, ray.direction, t_max));
        add_ray(arriving ? 32u + number : number, steps);
        if (arriving) continue;
        atomicMin(least[number], steps);
        atomicMax(most[number], steps);
    }
    subgroup_barrier();
    return count;
}

void main() {
    const ivec2 tile = ivec2(gl_WorkGroupID.xy);
    TileShare share = tile_share(inside_mask(tile));
    clear_rays(share);
    share.wanted = coloured_pixels(share, tile);
    uint rays = cast_rays(share, tile, false);
    TileShare mixed = share;
    mixed.wanted = mixed_pixels(share, tile);
    rays += cast_rays(mixed, tile, true);
    for (uint number = share.first + share.lane; number < share.end; number += share.lanes) {
        if ((share.wanted >> number & 1u) == 0u) continue;
        const ivec2 p = pixel_numbered(tile, number);
        store_transmittance(p, vec4(texelFetch(visibility, p, 0).x * mean_transmittance(number), 1.0));
    }
    count_coloured(subgroupElect() ? uint(bitCount(share.wanted)) : 0u);
    count_rays(subgroupElect() ? rays : 0u);
}
