// SPDX-License-Identifier: MIT
// What further rays of a pixel are worth: by how much each makes its squared error smaller. Of n rays to points that lie evenly
// over the sun the error falls as n^-1.6 (docs/budget.md).
//
// Includer has rounded.glsl.

// How many rays a pixel can have, its first one included.
const uint LEVELS = 12u;
const uint RAYS_AT[LEVELS] = uint[LEVELS](1u, 2u, 3u, 4u, 5u, 7u, 9u, 12u, 16u, 20u, 26u, 32u);

// Pixels are sorted by the squared error that one ray is expected to leave, v (1 - v) where nothing else is known.
const uint CLASSES = 4u;
const float EXPECTED[CLASSES] = float[CLASSES](0.19, 0.08, 0.015, 0.0012);
const float LEAST_OF[CLASSES] = float[CLASSES](0.125, 0.035, 0.0045, 0.0004);

// The gain's logarithm in steps, as a histogram counts it.
const uint GAIN_BINS = 256u;
const float GAIN_STEPS = 12.0, LEAST_GAIN = -24.0;  // per octave; log2

float error_after(float expected, uint rays) { return expected * pow(float(rays), -1.6); }

// Per ray, of going from one level to the next; `steps_less`: of a light that is one of several (light_share.glsl).
uint gain_bin(float expected, uint level, uint steps_less) {
    const uint rays = RAYS_AT[level], more = RAYS_AT[level + 1u];
    const float gain = (error_after(expected, rays) - error_after(expected, more)) / float(more - rays);
    const uint bin = rounded(clamp((log2(max(gain, 1e-12)) - LEAST_GAIN) * GAIN_STEPS, 0.0, float(GAIN_BINS - 1u)));
    return bin - min(bin, steps_less);
}
