// SPDX-License-Identifier: MIT
// Radiance in a word: three mantissas of 9 bits and the exponent that they share, as Vulkan's E5B9G9R9 has them: steps of 1/256 to
// 1/512 of the largest channel. Rounded up or down by thresholds that fill time and neighbourhoods evenly (common/dithered.glsl): a
// running mean of such words keeps its mean, and what is a whole number of steps stays as it is.
//
// Includer has common/rounded.glsl and common/dithered.glsl.

const int LEAST_STEP = -24;  // exponent of the smallest step; the largest is 2^7

float exponent_of_two(int e) { return uintBitsToFloat(uint(e + 127) << 23); }

// 0 <= c <= 65408 as whole numbers of 9 + further_bits bits and the exponent of their steps, less LEAST_STEP - further_bits.
uvec4 shared_steps(vec3 c, int further_bits, uint thresholds) {
    const float largest = max(max(c.x, c.y), c.z), most = float((512 << further_bits) - 1);
    const int least = LEAST_STEP - further_bits, octave = int(floatBitsToUint(largest) >> 23) - 127;
    int step_log2 = clamp(octave - 8 - further_bits, least, least + 31);
    if (largest * exponent_of_two(-step_log2) > most && step_log2 < least + 31) ++step_log2;  // no mantissa rounds up beyond its bits
    const vec3 steps = min(c * exponent_of_two(-step_log2), most);
    return uvec4(dithered(steps.x, threshold(thresholds, 0u)), dithered(steps.y, threshold(thresholds, 1u)),
                 dithered(steps.z, threshold(thresholds, 2u)), uint(step_log2 - least));
}

uint encode_radiance(vec3 c, uint thresholds) {
    const uvec4 steps = shared_steps(c, 0, thresholds);
    return steps.x | steps.y << 9 | steps.z << 18 | steps.w << 27;
}

vec3 decode_radiance(uint word) {
    return vec3(ivec3(uvec3(word, word >> 9, word >> 18) & 511u)) * exponent_of_two(int(word >> 27) + LEAST_STEP);
}
