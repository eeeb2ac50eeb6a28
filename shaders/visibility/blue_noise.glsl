// SPDX-License-Identifier: MIT
// Two sampling numbers per pixel and frame: a 128 x 128 blue-noise tile (nodes/tables/blue_noise.cpp), moved over the image by slow
// waves, which keep what makes it blue and end its repetition, and from frame to frame by an additive recurrence with two
// independent irrational steps: every pixel's sequence stays a low-discrepancy set for ever, and no frame count is too large.
// All in 32-bit fixed point, so that whoever asks for a pixel's numbers gets the same.
//
// Includer declares: uniform usampler2D blue_noise (r32ui, 128 x 128; texel = first channel | second << 16).

#include "common/hash.glsl"

const int blue_noise_size = 128;

// Steps per frame: .58491 and .30647, the best of some thousand pairs for means over the sun's disc (docs/noise.md).
const uvec2 NOISE_STEP = uvec2(2512169321u, 1316278627u);

// The waves, per channel: triangles over x, periods of 271.94 and 293.741 px, and over y, of 279.825 and 53.673 px, that
// rise by 2, 2, 2 and .5 in half a period; and a slope. Found by a search: 128, 256 ... px apart their values differ by whole
// turns and all between, and nowhere do they change by more than 1/50 per pixel and axis (docs/noise.md).
const uvec2 NOISE_WAVE_X = uvec2(15793805u, 14621613u), NOISE_WAVE_Y = uvec2(15348762u, 80021003u);
const uvec2 NOISE_RISE_X = uvec2(4u, 4u), NOISE_RISE_Y = uvec2(4u, 1u);  // in halves
const uvec2 NOISE_SLOPE_X = uvec2(2717909u, 4294306274u), NOISE_SLOPE_Y = uvec2(4291279664u, 4294571354u);

uvec2 noise_tile(ivec2 pixel, uint seed) {
    uint o = noise_hash(seed);
    ivec2 p = (pixel + ivec2(o & 127u, o >> 7 & 127u)) & (blue_noise_size - 1);
    uint texel = texelFetch(blue_noise, p, 0).r;
    return uvec2(texel << 16, texel & 0xFFFF0000u);
}

uvec2 noise_waves(ivec2 pixel) {
    const uvec2 x = uvec2(pixel.x), y = uvec2(pixel.y);
    return NOISE_RISE_X * uvec2(abs(ivec2(x * NOISE_WAVE_X))) + x * NOISE_SLOPE_X +
           NOISE_RISE_Y * uvec2(abs(ivec2(y * NOISE_WAVE_Y))) + y * NOISE_SLOPE_Y;
}

// fract(tile + waves + frame * step + h(seed)).
uvec2 noise_fixed(ivec2 pixel, uint frame, uint seed) {
    uint first = noise_hash(seed ^ 0x9E3779B9u), second = noise_hash(first);
    return noise_tile(pixel, seed) + noise_waves(pixel) + frame * NOISE_STEP + uvec2(first, second);
}

// Where the k-th of n samples of one pixel and frame lies from its first: the points (k / n, k / golden ratio) of the torus,
// as even for every n as a Fibonacci lattice is for its own. Turned by a uniform first sample each of them is uniform.
uvec2 noise_step(uint k, uint n) { return k * uvec2(0xFFFFFFFFu / n, 2654435769u); }

// The published form, for the baseline: 8-bit noise and one golden-ratio phase on both axes, so a pixel only ever samples
// one line of the square.
vec2 noise_published(ivec2 pixel, uint frame, uint seed) {
    vec2 noise = vec2(noise_tile(pixel, seed) >> 24) / 255.0;
    return fract(noise + float(frame & 255u) * 1.6180339887);
}
