// SPDX-License-Identifier: MIT
// A running mean of radiance: its word (radiance_word.glsl), and a byte with a tenth bit of each mantissa, since what a mirror shows
// is known better than the word tells, and the number of frames that it stands for: 0, or 2^(c / 5) for c of 0 to 30, rounded up or
// down like the mantissas.
//
// Includer has reflections/radiance_word.glsl.

struct Past {
    vec3 radiance;
    float frames;  // 1 to 64; 0: there is none
};

const float FRAME_STEPS = 5.0;  // per octave

uint encode_frames(float n, float threshold) {
    if (!(n > 0.0)) return 0u;
    const float below = floor(FRAME_STEPS * log2(clamp(n, 1.0, 64.0)) + 1e-3);  // a power of two is one
    const float low = exp2(below / FRAME_STEPS), high = exp2((below + 1.0) / FRAME_STEPS);
    return 1u + min(rounded(below) + (n - low > threshold * (high - low) ? 1u : 0u), 30u);
}

// x: the word; y: the byte.
uvec2 encode_past(Past past, uint thresholds) {
    const uvec4 steps = shared_steps(past.radiance, 1, thresholds);
    const uvec3 high = steps.xyz >> 1, low = steps.xyz & 1u;
    return uvec2(high.x | high.y << 9 | high.z << 18 | steps.w << 27,
                 encode_frames(past.frames, threshold(thresholds, 3u)) | low.x << 5 | low.y << 6 | low.z << 7);
}

vec3 past_radiance(uint word, uint byte) {
    const uvec3 steps = (uvec3(word, word >> 9, word >> 18) & 511u) << 1 | (uvec3(byte >> 5, byte >> 6, byte >> 7) & 1u);
    return vec3(ivec3(steps)) * exponent_of_two(int(word >> 27) + LEAST_STEP - 1);
}
bool has_past(uint byte) { return (byte & 31u) != 0u; }

Past decode_past(uint word, uint byte) {
    return Past(past_radiance(word, byte), has_past(byte) ? exp2((float(byte & 31u) - 1.0) / FRAME_STEPS) : 0.0);
}

// A byte as images of fractions keep it.
float byte_texel(uint byte) { return float(byte) / 255.0; }
uint texel_byte(float texel) { return rounded(255.0 * texel); }
