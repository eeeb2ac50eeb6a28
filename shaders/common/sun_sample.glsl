// SPDX-License-Identifier: MIT
// Directions towards the sun's disc from two uniform numbers. The exact form is uniform over the spherical cap; the
// published form is the tangent-plane disc of AMD's FidelityFX shadow denoiser sample, which is off by 1.6e-3 of
// visibility for a sun of 10 degrees and exists for the baseline only.

// A right-handed frame around a unit vector, without a branch or a pole. Duff, Burgess, Christensen, Hery, Kensler,
// Liani, Villemin 2017, "Building an Orthonormal Basis, Revisited".
mat3 sun_frame(vec3 to_sun) {
    float s = to_sun.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + to_sun.z);
    float b = to_sun.x * to_sun.y * a;
    return mat3(1.0 + s * to_sun.x * to_sun.x * a, s * b, -s * to_sun.x,
                b, s + to_sun.y * to_sun.y * a, -to_sun.y,
                to_sun);
}

// The square to the unit disc, areas kept. Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square". The
// middle of the square is the middle of the disc exactly, without 0 / 0.
vec2 concentric_disc(vec2 u) {
    vec2 p = 2.0 * u - 1.0;
    bool wide = abs(p.x) > abs(p.y);
    float r = wide ? p.x : p.y;
    float ratio = (wide ? p.y : p.x) / (r == 0.0 ? 1.0 : r);
    float angle = 0.7853981633974483 * ratio;
    float across = r * sin(angle), along = r * cos(angle);
    return wide ? vec2(along, across) : vec2(across, along);
}

// The same by polar coordinates: turning the disc is shifting u.x, so that numbers which are uniform prefer no direction.
vec2 polar_disc(vec2 u) {
    float angle = 6.283185307179586 * (u.x - 0.5);
    return sqrt(u.y) * vec2(cos(angle), sin(angle));
}

// The direction to a point of the sun's disc, which is of radius 1 here. The cap's azimuthal equal-area map takes disc
// radius r to 1 - cos(t) = 2 r^2 sin^2(a / 2); written in 1 - cos(t), nothing cancels for a small sun:
// sin(t) = sqrt(v (2 - v)). An angular radius of 0 gives `to_sun` itself, which is a unit vector, as the result is.
vec3 in_cap(float angular_radius, vec2 disc) {  // across the axes around its middle
    float h = sin(0.5 * angular_radius);
    float v = 2.0 * h * h * dot(disc, disc);
    // sin(t) / r, so that no direction is divided by its own zero length.
    float sine_per_radius = h * sqrt(2.0 * (2.0 - v));
    return vec3(disc * sine_per_radius, 1.0 - v);
}

vec3 sun_direction_through(vec3 to_sun, float angular_radius, vec2 disc) {
    return sun_frame(to_sun) * in_cap(angular_radius, disc);
}

// Uniform over the cap of `angular_radius` radians around `to_sun`. The disc comes from the concentric map, which keeps
// strata of the square compact.
vec3 sun_direction(vec3 to_sun, float angular_radius, vec2 u) {
    return sun_direction_through(to_sun, angular_radius, concentric_disc(u));
}

// The published form: a disc of radius tan(angular_radius) on the plane that touches the unit sphere at `to_sun`. Its own
// frame is a plain cross product there; the orientation does not matter.
vec3 sun_direction_published(vec3 to_sun, float angular_radius, vec2 u) {
    return normalize(sun_frame(to_sun) * vec3(concentric_disc(u) * tan(angular_radius), 1.0));
}

// A point of the disc as an image keeps it: two signed 16-bit fractions. As packSnorm2x16 and unpackSnorm2x16 have it, without
// conversions of floats, which software devices do lane by lane (rounded.glsl; 1.5 * 2^23 serves both signs), or a quotient.
const float POINT_STEP = 1.0 / 32767.0;
uint pack_point(vec2 disc) {
    const uvec2 fixed_point = floatBitsToUint(disc * 32767.0 + 12582912.0);
    return fixed_point.x & 0xffffu | fixed_point.y << 16;
}
vec2 unpack_point(uint word) { return POINT_STEP * vec2(int(word << 16) >> 16, int(word) >> 16); }
