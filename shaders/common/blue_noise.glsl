// SPDX-License-Identifier: MIT
// Two sampling numbers per pixel and frame: a 128 x 128 blue-noise tile (nodes/blue_noise.cpp), moved from frame to frame by
// an additive recurrence with two independent irrational steps (Roberts 2018, the R2 sequence), all in 32-bit fixed point:
// every pixel's sequence stays a low-discrepancy set for ever, and no frame count is too large.
//
// Includer declares: uniform usampler2D blue_noise (r32ui, 128 x 128; texel = first channel | second << 16).

#include "common/hash.glsl"

const int blue_noise_size = 128;

uvec2 noise_tile(ivec2 pixel, uint seed) {
    uint o = noise_hash(seed);
    ivec2 p = (pixel + ivec2(o & 127u, o >> 7 & 127u)) & (blue_noise_size - 1);
    uint texel = texelFetch(blue_noise, p, 0).r;
    return uvec2(texel << 16, texel & 0xFFFF0000u);
}

// fract(tile + frame * (0.7548776662, 0.5698402910) + h(seed)): the steps are 1/p and 1/p^2 for p^3 = p + 1, times 2^32.
uvec2 noise_r2_fixed(ivec2 pixel, uint frame, uint seed) {
    uint first = noise_hash(seed ^ 0x9E3779B9u), second = noise_hash(first);
    return noise_tile(pixel, seed) + frame * uvec2(3242174889u, 2447445414u) + uvec2(first, second);
}
vec2 noise_r2(ivec2 pixel, uint frame, uint seed) { return noise_unit(noise_r2_fixed(pixel, frame, seed)); }

// Where the k-th of n samples of one pixel and frame lies from its first: the points (k / n, k / golden ratio) of the torus,
// as even for every n as a Fibonacci lattice is for its own. Turned by a uniform first sample each of them is uniform.
uvec2 noise_step(uint k, uint n) { return k * uvec2(0xFFFFFFFFu / n, 2654435769u); }

// The published form, for the baseline: 8-bit noise and one golden-ratio phase on both axes, so a pixel only ever samples
// one line of the square.
vec2 noise_published(ivec2 pixel, uint frame, uint seed) {
    vec2 noise = vec2(noise_tile(pixel, seed) >> 24) / 255.0;
    return fract(noise + float(frame & 255u) * 1.6180339887);
}
