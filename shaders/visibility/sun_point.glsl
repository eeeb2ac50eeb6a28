// SPDX-License-Identifier: MIT
// Which point of the sun's disc a pixel's ray goes to: the one place that the tracer and whoever reads its bits ask. The
// disc has radius 1 and the axes of sun_frame(to_sun).
//
// Includer declares: uniform usampler2D blue_noise (see blue_noise.glsl).
#include "visibility/blue_noise.glsl"
#include "common/sun_sample.glsl"

vec2 sun_point(ivec2 pixel, uint frame, uint seed) { return polar_disc(noise_unit(noise_fixed(pixel, frame, seed))); }

// Of n rays the k-th; the first is the one above.
vec2 sun_point(ivec2 pixel, uint frame, uint seed, uint k, uint n) {
    return polar_disc(noise_unit(noise_fixed(pixel, frame, seed) + noise_step(k, n)));
}
