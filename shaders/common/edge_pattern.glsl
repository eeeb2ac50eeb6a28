// SPDX-License-Identifier: MIT
// What nine shadow rays say together. A pixel's own bit is right on average and far off in every single case; the bits of
// 3x3 pixels on one surface show where an edge runs through them and how soft it is. The table (nodes/edge_patterns.cpp)
// holds the centre's expected visibility for each of the 512 patterns: a third of the ray's squared error in a penumbra of
// one pixel, a quarter at two. It is biased where an edge is not what the table expects, so it never enters the history.
//
// Includer declares the table `edge_patterns` (r8, 32 x 16).

const uint PATTERN_CENTRE = 16u, WHOLE_PATTERN = 511u;
const float LEAST_SHARE = 1.0 / 64.0;  // of the pattern: less is not worth asking nine pixels' surface
const float CONVERGENCE = 1.75;        // of an average of rays: variance ~ n^-1.75, low-discrepancy samples average out faster than random ones

// Nine bits each, row by row. A pixel that is not `known`, because it is of another surface or receives nothing, says what
// the centre says.
uint edge_pattern(uint lit, uint known) {
    return (lit & PATTERN_CENTRE) != 0u ? lit | ~known & WHOLE_PATTERN : lit & known;
}

float visibility_by_pattern(uint pattern) {
    return texelFetch(edge_patterns, ivec2(pattern & 31u, pattern >> 5), 0).x;
}

// How much the pattern of bits counts beside an average over `frames` of some rays each, whose variance falls as the frames'
// -CONVERGENCEth power.
float share_of_pattern(float frames, float rays, float pattern_samples) {
    return pattern_samples / (pattern_samples + rays * pow(frames, CONVERGENCE) - 1.0 + 1e-6);
}
