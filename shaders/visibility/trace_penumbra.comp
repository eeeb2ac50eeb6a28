// SPDX-License-Identifier: MIT
// One shadow ray per undecided pixel, as trace casts it, whose nearest hit says how wide the penumbra is there: what SIGMA
// takes. One workgroup per listed tile; nothing is shared.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#if BACKEND == BACKEND_RAY_QUERY
#define NEAREST_HIT
#endif
#include "visibility/shadow_origin.glsl"
#include "visibility/transmittance.glsl"
#include "visibility/nearest_hit.glsl"
#include "visibility/sun_point.glsl"
#include "common/light.glsl"
#include "visibility/tile_share.glsl"

// Published values: 0 = turned away or touched by what hides the sun, 65504 = lit, between them the penumbra's radius.
const float LIT = 65504.0, WIDEST = 32768.0;

vec3 ray_direction(ivec2 p) {
    if (!HAS_BLUE_NOISE) return sun.to_sun;
    return sun_direction_through(sun.to_sun, sun.angular_radius, sun_point(p, frame.frame_index, params.seed));
}

LightRay ray_to_light(ivec2 p, vec3 to_centre) {
    if (!HAS_LIGHT) return LightRay(ray_direction(p), 1e30, 1e30);
    vec2 point = vec2(0.0);
    if (HAS_BLUE_NOISE) point = light_point(noise_unit(noise_fixed(p, frame.frame_index, params.seed)));
    return light_ray(to_centre, point);
}

// Metres; half of what the sun's radius spans at the blocker's distance, or half of the light's own behind the blocker.
float radius_behind(float distance_m, float light_m) {
    const float spanned = HAS_LIGHT ? light_radius_m() * distance_m / max(light_m - distance_m, 1e-6) : distance_m * tan(sun.angular_radius);
    return min(0.5 * spanned, WIDEST);
}

// `colour`: 1 where lit, and what translucent triangles leave of the light. The first of them is as much of a blocker as an opaque one.
float penumbra_at(ivec2 p, float t_min, float t_max, out vec4 colour) {
    colour = vec4(0.0);
    const vec3 n = decode_receiver_normal(imageLoad(receiver_normal, p).xy);
    vec3 centre = vec3(0.0);
    if (HAS_LIGHT) centre = light.centre + scene.camera_from_origin;
    const RayStart start = ray_start(p, n);
    const vec3 origin = HAS_LIGHT ? shadow_origin_to(start, n, centre) : shadow_origin(start, n, sun.to_sun);
    const LightRay ray = ray_to_light(p, centre - origin);
    if (points_into_surface(n, ray.direction)) return 0.0;
    if (HAS_LIGHT) t_max = min(t_max, ray.t_max);
    float t = t_max;
    const bool dark = nearest_hit(origin, start.beyond_edge_m, ray.direction, t_min, t_max, t);
    vec3 through = vec3(1.0);
    if (HAS_TRANSLUCENTS) through = transmittance_along(origin, ray.direction, t, true, t);
    const bool lit = !(t < t_max);
    if (!dark) colour = vec4(lit ? 1.0 : 0.0, through);
    return lit && !dark ? LIT : radius_behind(t, ray.t_plane);
}

void main() {
    uvec4 record;
    if (!listed_tile(record)) return;  // the whole workgroup
    const TileShare share = tile_share(record.y);
    const uint ray_count = uint(bitCount(share.wanted));
    for (uint first = 0u; first < ray_count; first += share.lanes) {
        const uint index = first + share.lane;
        if (index < ray_count) {
            const ivec2 p = tile_of(record) * TILE + pixel_of_lane(int(wanted_number(share, index)));
            vec4 colour;
            const float radius = penumbra_at(p, uintBitsToFloat(record.z), uintBitsToFloat(record.w), colour);
            store_penumbra(p, vec4(radius));
#if HAS_TRANSLUCENCY
            store_translucency(p, colour);
#endif
        }
    }
    count_rays(subgroupElect() ? ray_count : 0u);
}
