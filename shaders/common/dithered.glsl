// SPDX-License-Identifier: MIT
// Rounding that keeps the mean, for sums over frames in few bits: rounded to the nearest step, a running mean stands still as
// soon as a frame adds less than half of one. Up or down by a threshold instead, which runs evenly over a pixel's frames and over
// its neighbours, so that the errors of some frames, or of some pixels, add up to nearly nothing: Roberts 2018, "The Unreasonable
// Effectiveness of Quasirandom Sequences", in the plane, and the golden ratio in time.
//
// Includer has rounded.glsl.

// Fixed point, 32 bits.
uint thresholds_at(ivec2 p) {
    return uint(p.x) * 3242174889u + uint(p.y) * 2447445413u + frame.frame_index * 2654435769u;
}

// One of four, a quarter apart; never 0 or 1, so that what is a whole number stays one.
float threshold(uint thresholds, uint which) { return (float(int((thresholds + (which << 30)) >> 24)) + 0.5) / 256.0; }

// x >= 0 as a whole number.
uint dithered(float x, float threshold) { return rounded(max(x + threshold - 0.5, 0.0)); }

// x of 0 to 1 as c, on the scale (c / most)^2: finer where it is small.
uint dithered_root(float x, float most, float threshold) {
    const float y = x * most * most, below = floor(sqrt(y));
    return rounded(below) + (threshold < (y - below * below) / (2.0 * below + 1.0) ? 1u : 0u);
}
float squared(uint c, float most) { return float(int(c * c)) * (1.0 / (most * most)); }
