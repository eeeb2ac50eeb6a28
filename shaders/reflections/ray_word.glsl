// SPDX-License-Identifier: MIT
// The direction of a pixel's ray in a word, octahedral in two signed fractions of 16 bits; with HIT_NORMALS, for all but narrow lobes,
// of 10 bits, and the normal of the surface that it hit in two of 6. Narrow lobes need the digits, and their neighbours meet what they
// hit under much the same cosine. A normal along an axis is exact.
//
// Includer has common/receiver_normal.glsl and common/rounded.glsl and declares: constants LOBE, HIT_NORMALS.

const float LEAST_WIDE = 0.15;  // roughness: a direction is then off by less than a fifth of the lobe's alpha
const uint DIRECTION_BITS = 10u, NORMAL_BITS = 6u;
const float OFF = 1e-4, OFF_WIDE = 0.0042;  // radians by which a direction may be off, of 16 bits and of DIRECTION_BITS

struct RayWord {
    vec3 direction;
    vec3 hit_normal;  // 0 where it is not known
};

bool is_wide(float roughness) { return LOBE == LOBE_DIFFUSE || roughness >= LEAST_WIDE; }

bool keeps_hit_normal(float roughness) { return HIT_NORMALS && is_wide(roughness); }

uint pack_fractions(vec2 v, uint bits) {
    const float largest = float((1u << (bits - 1u)) - 1u);
    const vec2 steps = clamp(v, -1.0, 1.0) * largest + largest;
    return rounded(steps.x) | rounded(steps.y) << bits;
}

vec2 unpack_fractions(uint word, uint bits) {
    const float largest = float((1u << (bits - 1u)) - 1u);
    const uint mask = (1u << bits) - 1u;
    return vec2(word & mask, word >> bits & mask) / largest - 1.0;
}

uint encode_ray_word(RayWord ray, float roughness) {
    if (!keeps_hit_normal(roughness)) return pack_direction(ray.direction);
    return pack_fractions(encode_receiver_normal(ray.direction), DIRECTION_BITS) |
           pack_fractions(encode_receiver_normal(ray.hit_normal), NORMAL_BITS) << 2u * DIRECTION_BITS;
}

RayWord decode_ray_word(uint word, float roughness) {
    if (!keeps_hit_normal(roughness)) return RayWord(unpack_direction(word), vec3(0.0));
    return RayWord(decode_receiver_normal(unpack_fractions(word, DIRECTION_BITS)),
                   decode_receiver_normal(unpack_fractions(word >> 2u * DIRECTION_BITS, NORMAL_BITS)));
}
