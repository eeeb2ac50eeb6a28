// SPDX-License-Identifier: MIT
// What lamps shine on a point that a ray has hit, in lux: of each what cover_lights gives a surface that is seen directly, unshadowed
// lux times the share of the lamp that is seen. One lamp is drawn, with a chance in proportion to what it would shine here if nothing
// stood between, and divided by that chance; a shadow ray goes to one of its points, drawn as evenly as the share is meant.
//
// Includer has common/lights.glsl, common/illuminance.glsl, common/hash.glsl and reflections/closest_hit.glsl and declares: block scene.

const float MOST_LUX = 1e30;  // right beside a point; what is added to it stays finite

// Independent of the numbers that they are made of.
vec3 lamp_numbers(vec2 u) {
    const uint a = noise_hash(floatBitsToUint(u.x) ^ noise_hash(floatBitsToUint(u.y))), b = noise_hash(a);
    return vec3(noise_unit(uvec2(a, b)), noise_unit(uvec2(noise_hash(b))).x);
}

vec3 from_here(vec3 point) { return light.centre + scene.camera_from_origin - point; }

// `point`: in the scene's frame, off the surface.
vec3 lux_of_lamps(vec3 point, vec3 normal, vec3 u) {
    vec3 lux = vec3(0.0);
    float sum = 0.0, own = 0.0, lot = u.x;
    int drawn = 0;
    for (int i = 0; i < light_count(); ++i) {
        light = light_at(i);
        const vec3 unshadowed = min(unshadowed_lux(normal, from_here(point)), MOST_LUX);
        const float weight = unshadowed.x + unshadowed.y + unshadowed.z;
        if (!(weight > 0.0)) continue;
        // The one that is drawn of those so far; what is left of the number is as even as it was.
        sum += weight;
        const float chance = weight / sum;
        const bool taken = lot < chance;
        lot = taken ? lot / chance : (lot - chance) / max(1.0 - chance, 1e-7);
        if (taken) {
            lux = unshadowed;
            own = weight;
            drawn = i;
        }
    }
    if (!(own > 0.0)) return vec3(0.0);
    light = light_at(drawn);
    const LightRay ray = light_ray(from_here(point), light_point(u.yz));
    if (!(dot(normal, ray.direction) > 0.0) || occluded(point, ray.direction, 0.0, ray.t_max)) return vec3(0.0);
    return lux * (sum / own);
}
