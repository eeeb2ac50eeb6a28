// SPDX-License-Identifier: MIT
// Exact coverage of several lights that are near. A workgroup has a tile: it reads its pixels once and goes from light to light, and those of
// its pixels that a light can reach walk the tree with their cone to it, as in cover.comp. A light that is off, out of range, behind or below
// all of them costs a test per pixel. docs/lights.md.
#extension GL_KHR_shader_subgroup_shuffle : require
#include "node.glsl"
#include "common/camera.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#include "visibility/shadow_origin.glsl"
#include "visibility/sun_point.glsl"
const bool HAS_LIGHT = true;
#include "common/lights.glsl"
#include "common/illuminance.glsl"
#include "common/finite.glsl"
#include "common/tiles.glsl"
#include "visibility/tile_share.glsl"
#define SHARED_STACK
#define SHARED_VIEWER
#include "visibility/transmittance.glsl"
#include "visibility/coloured_light.glsl"
#if BACKEND == BACKEND_BVH
#include "visibility/light_mask.glsl"
#include "visibility/leaf_cover.glsl"
#include "visibility/seen_light.glsl"
#define WALK_BUDGET BUDGET
#include "visibility/light_walk.glsl"

ConeSlabs slabs_to(SeenLight seen) { return seen.slabs; }
#endif

// Of the 32 lights from the first one on, a bit for each that may. Each lane asks others, and then all have the same again, which a GPU keeps in
// scalar registers.
uint lights_that_reach(TileShare share, int first, vec3 lower, vec3 upper) {
    const Light before = light;
    uint found = 0u;
    for (uint k = share.lane; k < 32u; k += share.lanes) {
        const int i = first + int(k);
        light = light_at(min(i, light_count() - 1));
        const vec3 centre = light.centre + scene.camera_from_origin;
        if (i < light_count() && light_may_reach(lower - centre, upper - centre)) found |= 1u << k;
    }
    light = before;
    return subgroupOr(found);
}

// Of a tile's pixels, by their numbers.
shared vec4 starts[32];  // w: RayStart's beyond_edge_m
shared vec3 normals[32], lux[32];

#if HAS_MASKS || HAS_TRANSMITTANCES
#define KEEPS_LAYERS
int layer_count() {
#if HAS_MASKS
    return imageSize(masks).z;
#else
    return imageSize(transmittances).z;
#endif
}

void keep(ivec2 tile, uint number, int layer, float share, vec3 through) {
    if (layer >= layer_count()) return;  // of a host that has more lights than the plan
    const ivec3 at = ivec3(tile * TILE + pixel_of_lane(int(number)), layer);
#if HAS_MASKS
    imageStore(masks, at, vec4(share));
#endif
#if HAS_TRANSMITTANCES
    imageStore(transmittances, at, vec4(share * through, 1.0));
#endif
}
#endif

struct Seen {
    float share;  // of the light
    bool asked;   // of rays
    uint steps;
};

// All rays to a point are one.
uint rays_to_light(uint rays) { return light_bound_m() > 0.0 ? rays : 1u; }

vec2 point_of_ray(ivec2 p, uint k, uint rays) {
    return light_point(noise_unit(noise_fixed(p, frame.frame_index, params.seed) + noise_step(k, rays)));
}

#if BACKEND == BACKEND_RAY_QUERY
Seen look(ivec2 p, RayStart surface, vec3 normal, bool own) {
    const vec3 centre = light.centre + scene.camera_from_origin;
    const vec3 start = shadow_origin_to(surface, normal, centre), to_light = centre - start;
    const uint rays = rays_to_light(RAYS);
    uint lit = 0u;
    for (uint k = 0u; own && k < rays; ++k) {
        const LightRay ray = light_ray(to_light, point_of_ray(p, k, rays));
        if (!points_into_surface(normal, ray.direction) && !occluded(start, ray.direction, 0.0, ray.t_max)) ++lit;
    }
    return Seen(float(lit) / float(rays), false, 0u);
}
#else
// A walk that was given up leaves samples that nothing hides yet: rays say what the rest of it would have.
Seen look(ivec2 p, RayStart surface, vec3 normal, bool own) {
    const SeenLight seen = seen_light(surface, noise_unit(noise_fixed(p, frame.frame_index, params.seed)));
    LightMask hidden = below_horizon(seen, normal);
    const Walk walk = walk_to_light(seen, own, hidden);
    const bool given_up = own && !walk.ended;
    hidden = with_samples_by_ray(seen, 1.0, given_up || (own && last_samples(hidden)), hidden);
    return Seen(float(LIGHT_SAMPLES - mask_count(hidden)) / float(LIGHT_SAMPLES), given_up, walk.steps);
}
#endif

// Of what arrives of the light the share that translucent triangles let through: the mean over rays, and where a part of the light is
// hidden and it differs from ray to ray, over those that arrive; where none does all are as likely.
vec3 mean_transmittance(ivec2 p, uint number, vec3 start, vec3 normal, vec3 to_light, float seen, bool wanted) {
    const bool coloured = near_light_may_be_coloured(start, wanted);
    const uint rays = rays_to_light(TRANSLUCENT_RAYS);
    vec3 sum = vec3(0.0);
    float count = 0.0;
    uint first = 0u, mean = 0u;  // packed: of the first ray, of all
    bool differ = false;
    for (uint k = 0u; coloured && k < (differ && seen < 1.0 ? 2u * rays : rays); ++k) {
        const bool again = k >= rays;
        if (k == rays) {
            mean = pack_transmittance(sum / count);
            sum = vec3(0.0);
            count = 0.0;
        }
        const LightRay ray = light_ray(to_light, point_of_ray(p, again ? k - rays : k, rays));
        float unread = 0.0;
        if (again && (points_into_surface(normal, ray.direction) || occluded_from(start, starts[number].w, ray.direction, 0.0, ray.t_max, unread))) continue;
        const vec3 through = transmittance_along(start, ray.direction, ray.t_max);
        sum += through;
        ++count;
        if (k == 0u) first = pack_transmittance(through);
        if (pack_transmittance(through) != first) differ = true;
    }
    if (!coloured) return vec3(1.0);
    return count > 0.0 ? sum / count : unpack_transmittance(mean);
}

void main() {
    const ivec2 tile = ivec2(gl_WorkGroupID.xy);
    const uint inside = lanes_of_pixels(inside_mask(tile));
    TileShare share = tile_share(~0u);
    uint surfaces = 0u;
    vec3 lower = vec3(3e38), upper = vec3(-3e38);
    for (uint number = share.first + share.lane; number < share.end; number += share.lanes) {
        const ivec2 p = tile * TILE + pixel_of_lane(int(number));
        const bool surface = (inside >> number & 1u) != 0u && imageLoad(view_depth, p).x > 0.0;
        if (surface) {
            const vec3 n = decode_receiver_normal(imageLoad(receiver_normal, p).xy);
            normals[number] = n;
            const RayStart start = ray_start(p, n);
            starts[number] = vec4(start.off_surface, start.beyond_edge_m);
            lower = min(lower, start.off_surface);
            upper = max(upper, start.off_surface);
            surfaces |= 1u << number;
        }
        lux[number] = vec3(0.0);
    }
#if BACKEND != BACKEND_RAY_QUERY
    see_viewer();
    if (!ON_CPU) group_barrier();
#endif
    subgroup_barrier();

    lower = subgroupMin(lower);
    upper = subgroupMax(upper);

    uint reached = 0u, walked = 0u, shadowed = 0u, penumbra = 0u, asked = 0u, steps = 0u;
    uint rest = 0u;   // of the share's pixels, those that have not walked to the light yet
    uint candidates = 0u;  // of the last 32 lights that were tested, those that may reach one of them
    int index = 0, tested = 0;
    // A turn of this loop is a walk: a software device does all that is in it, whoever wants it.
    while (true) {
        while (rest == 0u && (candidates != 0u || tested < light_count())) {
            if (candidates == 0u) {
                candidates = lights_that_reach(share, tested, lower, upper);
#ifdef KEEPS_LAYERS
                for (int i = tested; i < min(tested + 32, light_count()); ++i)
                    for (uint number = share.first + share.lane; number < share.end; number += share.lanes)
                        if ((inside >> number & 1u) != 0u && (candidates >> (i - tested) & 1u) == 0u) keep(tile, number, i, 1.0, vec3(1.0));
#endif
                tested += 32;
            }
            if (candidates == 0u) continue;
            index = tested - 32 + findLSB(candidates);
            candidates &= candidates - 1u;
            light = light_at(index);
            const vec3 centre = light.centre + scene.camera_from_origin;
            uint open = 0u;
            for (uint number = share.first + share.lane; number < share.end; number += share.lanes) {
                const vec3 to_light = centre - starts[number].xyz;
                const bool here = (surfaces >> number & 1u) != 0u && light_reaches(-to_light);
                const bool below = here && light_is_below(normals[number], to_light, 1e-6);
                if (here) ++reached;
                if (here && !below) open |= 1u << number;
#ifdef KEEPS_LAYERS
                if ((inside >> number & 1u) != 0u && (!here || below)) keep(tile, number, index, below ? 0.0 : 1.0, vec3(1.0));
#endif
            }
            rest = subgroupOr(open);
        }
        if (rest == 0u) break;
        const uint count = uint(bitCount(rest));
        const bool own = share.lane < count;
        const uint number = bit_number(rest, own ? share.lane : 0u);
        const ivec2 p = tile * TILE + pixel_of_lane(int(number));
        const vec3 centre = light.centre + scene.camera_from_origin, normal = normals[number];
        const RayStart surface = RayStart(starts[number].xyz, starts[number].w);
        const vec3 start = shadow_origin_to(surface, normal, centre), to_light = centre - start;
        const Seen seen = look(p, surface, normal, own);
        vec3 through = vec3(1.0);
        if (HAS_TRANSLUCENTS) through = mean_transmittance(p, number, start, normal, to_light, seen.share, own && seen.share > 0.0);
        if (own) {
            ++walked;
#if HAS_ILLUMINANCE
            if (seen.share > 0.0) lux[number] += seen.share * through * unshadowed_lux(normal, to_light);
#endif
#ifdef KEEPS_LAYERS
            keep(tile, number, index, seen.share, through);
#endif
            if (seen.share == 0.0) ++shadowed;
            if (seen.share > 0.0 && seen.share < 1.0) ++penumbra;
            if (seen.asked) ++asked;
            steps += seen.steps;
        }
        rest &= ~subgroupOr(own ? 1u << number : 0u);
        subgroup_barrier();
    }
    count_reached(reached);
    count_walked(walked);
    count_shadowed(shadowed);
    count_penumbra(penumbra);
    count_asked(asked);
    // A driver that ends loops (light_walk.glsl) leaves lights undone.
    const bool undone = rest != 0u || candidates != 0u || tested < light_count();
    count_left(undone ? uint(bitCount(surfaces)) : 0u);
    count_steps(steps);
#ifdef KEEPS_LAYERS
    for (int i = light_count(); i < layer_count(); ++i)  // of a host that has fewer lights than the plan now
        for (uint number = share.first + share.lane; number < share.end; number += share.lanes)
            if ((inside >> number & 1u) != 0u) keep(tile, number, i, 1.0, vec3(1.0));
#endif
#if HAS_ILLUMINANCE
    subgroup_barrier();
    for (uint number = share.first + share.lane; number < share.end; number += share.lanes)
        if ((inside >> number & 1u) != 0u)
            store_illuminance(tile * TILE + pixel_of_lane(int(number)), vec4(storable(lux[number]), 0.0));
#endif
}
