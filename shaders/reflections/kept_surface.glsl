// SPDX-License-Identifier: MIT
// What a pixel showed, for the next frame to know it again, in a word: the view depth's logarithm in 12 bits (steps of half a
// percent from 2^-10 to 2^21 m), the normal, octahedral, in twice 6 (off by 4 degrees at most), the roughness in 8. 0: nothing.
//
// Includer has common/receiver_normal.glsl and common/rounded.glsl.

const float DEPTH_STEPS = 132.0, LEAST_DEPTH_LOG2 = -10.0;  // per octave

uint encode_kept(float z, vec3 n, float roughness) {
    const uint depth = 1u + rounded(clamp(DEPTH_STEPS * (log2(z) - LEAST_DEPTH_LOG2), 0.0, 4094.0));
    const vec2 octahedral = 31.5 + 31.5 * encode_receiver_normal(n);
    return depth | rounded(octahedral.x) << 12 | rounded(octahedral.y) << 18 | rounded(255.0 * roughness) << 24;
}

struct KeptSurface {
    float z;  // 0: none
    vec3 n;
    float roughness;
};

KeptSurface decode_kept(uint word) {
    if (word == 0u) return KeptSurface(0.0, vec3(0.0), 1.0);
    const vec2 octahedral = vec2(uvec2(word >> 12, word >> 18) & 63u) / 31.5 - 1.0;
    return KeptSurface(exp2((float(word & 0xfffu) - 1.0) / DEPTH_STEPS + LEAST_DEPTH_LOG2), decode_receiver_normal(octahedral),
                       float(word >> 24) / 255.0);
}
