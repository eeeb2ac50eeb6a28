// SPDX-License-Identifier: MIT
// What arrives along a ray: the light that leaves the surface it hits, or the environment. A hit surface is a Lambert one of its base
// colour, metal or not, under the sun and the lamps, with a shadow ray each, shines, and gets a constant in place of further bounces:
// the integrand of truth and of every denoised ray alike.
//
// Includer has reflections/closest_hit.glsl, hit_surface.glsl and environment.glsl, common/sun_sample.glsl, common/hash.glsl and
// common/finite.glsl and declares: block sun, where HAS_SUN; texels lights, where HAS_LIGHTS; params sun_color, exposure, ambient.
#include "common/lights.glsl"
#include "common/illuminance.glsl"
#include "reflections/lamps_at_hit.glsl"

const float FARTHEST_M = 1e30;
const float MISS_M = 65504.0;  // a distance that stands for "nothing": the largest half

struct Incident {
    vec3 radiance;   // not negative, at most MAX_RADIANCE
    float distance_m;  // at most MISS_M, which is no hit or one as far
    vec3 normal;     // of what it hit, 0 without a hit
    bool moves;      // what it hit stands elsewhere than in the previous frame
};

// Off the hit surface, where the next ray starts: 16 ulps of the numbers that the point was made of: a hit along a ray is known less well than a pixel's (common/ray_offset.glsl).
vec3 leave_hit(vec3 point, vec3 normal, float distance_m) {
    const vec3 size = abs(point);
    return point + normal * (16.0 * 1.1920929e-7 * (size.x + size.y + size.z + distance_m));
}

vec3 light_of_sun(HitSurface hit, float distance_m, vec2 u) {
    if (!HAS_SUN) return vec3(0.0);
    const vec3 to_sun = sun_direction(sun.to_sun, sun.angular_radius, u);
    const float cosine = dot(hit.normal, to_sun);
    if (!(cosine > 0.0)) return vec3(0.0);
    if (occluded(leave_hit(hit.point, hit.normal, distance_m), to_sun, 0.0, FARTHEST_M)) return vec3(0.0);
    return params.sun_color * cosine;
}

vec3 light_of_lamps(HitSurface hit, float distance_m, vec2 u) {
    const vec3 start = leave_hit(hit.point, hit.normal, distance_m);
    return params.exposure * 0.31830989 * lux_of_lamps(start, hit.normal, lamp_numbers(u));
}

// `origin` in the scene's frame, `direction` a unit vector; `u`: where on the sun's disc the shadow ray goes, and what the lamp's is
// drawn with.
Incident incident(vec3 origin, vec3 direction, vec2 u) {
    const ClosestHit ray = closest_hit(origin, direction, 0.0, FARTHEST_M);
    if (!ray.found) return Incident(storable(environment_radiance(direction)), MISS_M, vec3(0.0), false);
    const HitSurface hit = hit_surface(ray.triangle, origin + ray.t * direction, direction);
    vec3 arriving = params.ambient + light_of_sun(hit, ray.t, u);
    if (HAS_LIGHTS) arriving += light_of_lamps(hit, ray.t, u);
    return Incident(storable(hit.emissive + hit.base_color * arriving), min(ray.t, MISS_M), hit.normal, hit.moves);
}
