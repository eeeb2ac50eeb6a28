// SPDX-License-Identifier: MIT
// What a gather found, in two words: radiance (radiance_word.glsl); and of the higher bits of halves the distance in 7 bits of mantissa,
// the deviation in 6, with 8 bits of the number of samples in tenths. 0 stays 0.
//
// Includer has reflections/radiance_word.glsl.

struct Gathered {
    vec3 radiance;     // demodulated
    float distance_m;  // harmonic mean
    bool moving;       // a tenth or more hit something that moves
    float deviation;   // expected, over all channels
    float samples;     // that it stands for: 1 to 25; 0: no ray nearby tells of this lobe
};

// x >= 0 as a half, rounded to the nearest of those with `dropped` zeros at the end; at most the largest of those.
uint half_bits(float x, uint dropped) { return min((packHalf2x16(vec2(x, 0.0)) & 0x7fffu) + (1u << dropped >> 1), 0x7bffu) >> dropped; }
float half_of(uint bits, uint dropped) { return unpackHalf2x16(bits << dropped).x; }

uvec2 encode_gathered(Gathered g, uint thresholds) {
    return uvec2(encode_radiance(g.radiance, thresholds), half_bits(g.distance_m, 3u) | (g.moving ? 1u << 12 : 0u) |
                                                              half_bits(g.deviation, 4u) << 13 | rounded(min(10.0 * g.samples, 255.0)) << 24);
}

Gathered decode_gathered(uvec2 words) {
    return Gathered(decode_radiance(words.x), half_of(words.y & 0xfffu, 3u), (words.y >> 12 & 1u) != 0u, half_of(words.y >> 13 & 0x7ffu, 4u),
                    0.1 * float(words.y >> 24));
}
