// SPDX-License-Identifier: MIT
// A drift between past and gather, in two words: three signed mantissas of 9 bits and the exponent that they share, to the nearest
// step; and two deviations as halves.
//
// Includer has common/rounded.glsl, common/round_store.glsl and reflections/radiance_word.glsl.

const int LEAST_DRIFT_STEP = -23;

uint encode_drift(vec3 d) {
    const float largest = max(max(abs(d.x), abs(d.y)), abs(d.z));
    const int step_log2 = clamp(int(floatBitsToUint(largest * (256.0 / 255.0)) >> 23) - 127 - 7, LEAST_DRIFT_STEP, LEAST_DRIFT_STEP + 31);
    const vec3 steps = clamp(d * exponent_of_two(-step_log2), -255.0, 255.0) + 256.0;
    return rounded(steps.x) | rounded(steps.y) << 9 | rounded(steps.z) << 18 | uint(step_log2 - LEAST_DRIFT_STEP) << 27;
}

vec3 decode_drift(uint word) {
    return (vec3(uvec3(word, word >> 9, word >> 18) & 511u) - 256.0) * exponent_of_two(int(word >> 27) + LEAST_DRIFT_STEP);
}

uint encode_deviations(vec2 deviations) { return packHalf2x16(min(round_to(deviations, HALF_BITS), 65504.0)); }
vec2 decode_deviations(uint word) { return unpackHalf2x16(word); }
