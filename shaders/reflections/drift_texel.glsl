// SPDX-License-Identifier: MIT
// A drift between gather and past, in two words: three signed mantissas of 9 bits and the exponent that they share, to the nearest
// step; and two deviations as halves.
//
// Includer has common/rounded.glsl, common/round_store.glsl and reflections/radiance_word.glsl.

struct Drift {
    vec3 mean;       // running mean of gathered - past
    float of_mean2;  // variance of what the gathers are worth in it: known term by term, with the weights that they have
    float of_past2;  // variance of the past, likewise
};

const int LEAST_DRIFT_STEP = -23;

uvec2 encode_drift(Drift d) {
    const float largest = max(max(abs(d.mean.x), abs(d.mean.y)), abs(d.mean.z));
    const int octave = int(floatBitsToUint(largest * (256.0 / 255.0)) >> 23) - 127;
    const int step_log2 = clamp(octave - 7, LEAST_DRIFT_STEP, LEAST_DRIFT_STEP + 31);
    const vec3 steps = clamp(d.mean * exponent_of_two(-step_log2), -255.0, 255.0) + 256.0;
    const vec2 deviations = min(round_to(sqrt(vec2(d.of_mean2, d.of_past2)), HALF_BITS), 65504.0);
    return uvec2(rounded(steps.x) | rounded(steps.y) << 9 | rounded(steps.z) << 18 | uint(step_log2 - LEAST_DRIFT_STEP) << 27,
                 packHalf2x16(deviations));
}

Drift decode_drift(uvec2 words) {
    const vec3 steps = vec3(ivec3(uvec3(words.x, words.x >> 9, words.x >> 18) & 511u)) - 256.0;
    const vec2 deviations = unpackHalf2x16(words.y);
    return Drift(steps * exponent_of_two(int(words.x >> 27) + LEAST_DRIFT_STEP), deviations.x * deviations.x, deviations.y * deviations.y);
}
