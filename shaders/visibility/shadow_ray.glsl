// SPDX-License-Identifier: MIT
// The shadow rays of a pixel: from its surface towards points of the sun's disc per pixel and frame (common/sun_sample.glsl,
// blue_noise.glsl), or of a light that is near (common/light.glsl). A light that is a point takes no noise.
//
// Includer has common/camera.glsl, common/receiver_normal.glsl and common/ray_origin.glsl and declares: constants BACKEND, ORIGIN and
// SAMPLING; block light; buffer ray_points, where HAS_RAY_POINTS.
#include "visibility/shadow_origin.glsl"
#include "visibility/sun_point.glsl"
#include "common/light.glsl"

struct ShadowRay {
    vec3 origin, direction;
    float beyond_edge_m;  // how far the origin may lie past the end of what it is on
    bool into_surface;  // the surface itself hides the light
    float t_max;        // where the light is, metres
    float t_plane;      // where the plane through its middle is
};

const float SUN_IS_AT_M = 1e30;  // as classify's records end

// Hybrid Shadows sample: both constants are absolute lengths.
const float PUBLISHED_OFFSET_M = 1e-4;
const float PUBLISHED_T_MIN_M = 4e-2;

// The published form knows no light that is near.
float nearest_hit_m(float t_min) { return !HAS_LIGHT && ORIGIN == ORIGIN_PUBLISHED ? max(t_min, PUBLISHED_T_MIN_M) : t_min; }

// For whoever counts this pixel's ray as a neighbour's.
void keep_point(ivec2 p, uint point) {
#if HAS_RAY_POINTS
    ray_points[uint(p.y) * frame.size.x + uint(p.x)] = point;
#endif
}

// Of the k-th of a pixel's rays. The first, whose point is kept, is the one that is cast where there is no other: who reads the
// hit words knows where it went.
vec3 ray_direction(ivec2 p, uint k, uint rays) {
    if (!HAS_BLUE_NOISE) {
        keep_point(p, 0u);  // the middle of a sun that is a point
        return sun.to_sun;
    }
    if (SAMPLING == SAMPLING_PUBLISHED) {
        const vec2 u = fract(noise_published(p, frame.frame_index, params.seed) + noise_unit(noise_step(k, rays)));
        if (k == 0u) keep_point(p, pack_point(concentric_disc(u)));
        return sun_direction_published(sun.to_sun, sun.angular_radius, u);
    }
    const vec2 point = sun_point(p, frame.frame_index, params.seed, k, rays);
    if (k == 0u) keep_point(p, pack_point(point));
    return sun_direction_through(sun.to_sun, sun.angular_radius, point);
}

ShadowRay ray_to_near_light(ivec2 p, vec3 n, uint k, uint rays) {
    const vec3 centre = light.centre + scene.camera_from_origin;
    const RayStart start = ray_start(p, n);
    const vec3 origin = shadow_origin_to(start, n, centre);
    vec2 point = vec2(0.0);
    if (HAS_BLUE_NOISE)
        point = light_point(noise_unit(noise_fixed(p, frame.frame_index, params.seed) + noise_step(k, rays)));
    if (k == 0u) keep_point(p, pack_point(point));
    const LightRay ray = light_ray(centre - origin, point);
    return ShadowRay(origin, ray.direction, start.beyond_edge_m, points_into_surface(n, ray.direction), ray.t_max, ray.t_plane);
}

ShadowRay shadow_ray(ivec2 p, uint k, uint rays) {
    const vec3 n = decode_receiver_normal(texelFetch(receiver_normal, p, 0).xy);
    if (HAS_LIGHT) return ray_to_near_light(p, n, k, rays);
    const vec3 direction = ray_direction(p, k, rays);
    if (ORIGIN == ORIGIN_PUBLISHED) {
        const vec3 in_scene = position(p, imageLoad(view_depth, p).x) + scene.camera_from_origin;
        return ShadowRay(in_scene + n * PUBLISHED_OFFSET_M, direction, 0.0, false, SUN_IS_AT_M, SUN_IS_AT_M);
    }
    const RayStart start = ray_start(p, n);
    return ShadowRay(shadow_origin(start, n, sun.to_sun), direction, start.beyond_edge_m, points_into_surface(n, direction), SUN_IS_AT_M, SUN_IS_AT_M);
}
