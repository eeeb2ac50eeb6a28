// SPDX-License-Identifier: MIT
// Rays that are aimed at bodies that shine: half of those of a pixel which has one go into the cone around that body, the
// other half into its lobe, and a ray's density is that of both together.
//
// Includer has common/sun_sample.glsl and reflections/lobe.glsl and declares: uniform usamplerBuffer emitters (host/materials/emitters.h).

struct Emitter {
    vec3 center;  // camera-relative
    float radius;  // 0: none
};

Emitter emitter_of(uint number) {
    if (number == 0u) return Emitter(vec3(0.0), 0.0);
    const uvec4 sphere = texelFetch(emitters, int(2u * (number - 1u)));
    return Emitter(uintBitsToFloat(sphere.xyz), uintBitsToFloat(sphere.w));
}

// How much of the lobe goes into its disc, roughly: of GGX as it is around the mirrored direction, whose marginal along an axis has the
// cumulative distribution (1 + t / sqrt(1 + t^2)) / 2, t in units of 2 alpha.
float share_of_lobe(Emitter emitter, vec3 x, Lobe lobe) {
    const vec3 to = emitter.center - x;
    const float m = length(to), unit = 2.0 * sqrt(lobe.alpha2), away = length(to / m - reflect(-lobe.v, lobe.n)), radius = emitter.radius / m;
    const vec3 t = vec3(away + radius, away - radius, radius) / unit, below = t * inversesqrt(1.0 + t * t);
    return 0.5 * (below.x - below.y) * below.z;
}

// Of the cone around it.
float solid_angle(float sine2) { return 6.283185307179586 * sine2 / (1.0 + sqrt(1.0 - sine2)); }

// Evenly in the cone. `x` is outside of the sphere, `u` in 0..1.
vec3 aimed_direction(Emitter emitter, vec3 x, vec2 u) {
    const vec3 to = emitter.center - x;
    const float d2 = dot(to, to), sine2 = emitter.radius * emitter.radius / d2;
    const float height = u.y * sine2 / (1.0 + sqrt(1.0 - sine2)), across = sqrt(height * (2.0 - height)), angle = 6.283185307179586 * u.x;
    return normalize(sun_frame(to * inversesqrt(d2)) * vec3(across * vec2(cos(angle), sin(angle)), 1.0 - height));
}

// Whether the ray from x along a unit vector meets its sphere, or passes it by so many metres. Never from within.
bool lies_in_cone(Emitter emitter, vec3 x, vec3 l, float beside_m) {
    const vec3 to = emitter.center - x, off = cross(l, to);
    const float reach = emitter.radius + beside_m;
    return dot(to, to) > emitter.radius * emitter.radius && dot(l, to) > 0.0 && dot(off, off) < reach * reach;
}

bool lies_in_cone(Emitter emitter, vec3 x, vec3 l) { return lies_in_cone(emitter, x, l, 0.0); }

// Per steradian within the cone.
float cone_density(Emitter emitter, vec3 x) {
    const vec3 to = emitter.center - x;
    return 1.0 / solid_angle(min(emitter.radius * emitter.radius / dot(to, to), 1.0));
}
