// SPDX-License-Identifier: MIT
// The receiver's own normal, for rays: octahedral (Meyer et al. 2010, "On Floating-Point Normal Vectors") in two 32-bit
// floats, exact to rounding. It decides which rays of the sun's disc point into the surface, and the disc is a hundredth
// of a radian wide: the guides' 10 bits would move the receiver's horizon by a fifth of it. Defined where a surface is.

vec2 sign_of(vec2 v) { return mix(vec2(-1.0), vec2(1.0), greaterThanEqual(v, vec2(0.0))); }

vec2 encode_receiver_normal(vec3 n) {
    const vec3 m = n / (abs(n.x) + abs(n.y) + abs(n.z));
    return m.z >= 0.0 ? m.xy : (1.0 - abs(m.yx)) * sign_of(m.xy);
}

// In the normal's direction, on the octahedron.
vec3 octahedral_point(vec2 e) {
    const float z = 1.0 - abs(e.x) - abs(e.y);
    return vec3(z >= 0.0 ? e : (1.0 - abs(e.yx)) * sign_of(e), z);
}

vec3 decode_receiver_normal(vec2 e) { return normalize(octahedral_point(e)); }

// In two signed 16-bit fractions, rounded to the nearest: off by 6.5e-5 radians at most. The octahedron is nearest to its middle in
// p = (1, 1, 1) / 3, .577 away; half a step of both fractions, 1 / 65534, moves p by (1, 1, -2) / 65534, which is 3.7e-5 and across p.
uint pack_direction(vec3 n) { return packSnorm2x16(encode_receiver_normal(n)); }
vec3 unpack_direction(uint word) { return decode_receiver_normal(unpackSnorm2x16(word)); }

// Whether a ray from the surface points into it: it meets the surface, also where its origin, offset above the surface,
// would let it slip past an edge.
bool points_into_surface(vec3 n, vec3 direction) { return dot(n, direction) <= 0.0; }

// Whether no ray of the sun's cap points into the surface. The least cosine is that of the rim's far end.
bool cap_leaves_surface(vec3 n, vec3 to_sun, float angular_radius) {
    const float cosine = dot(n, to_sun);
    const float least = cosine * cos(angular_radius) - sqrt(max(1.0 - cosine * cosine, 0.0)) * sin(angular_radius);
    return least > 1e-5;  // beyond rounding of the directions
}
