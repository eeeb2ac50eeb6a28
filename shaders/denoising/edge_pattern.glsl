// SPDX-License-Identifier: MIT
// What nine shadow rays say together. A pixel's own bit is right on average and far off in every single case; the bits of
// 3x3 pixels on one surface show where an edge runs through them and how soft it is. The table (nodes/tables/edge_patterns.cpp)
// holds the centre's expected visibility for each of the 512 patterns: a third of the ray's squared error in a penumbra of
// one pixel, a quarter at two. It is biased where an edge is not what the table expects, so it never enters the history.
//
// Includer has view_rays.glsl, guide_normal.glsl, corners.glsl and bit_rows.glsl with R = 1, and declares the table `edge_patterns`
// (r8, 32 x 16) and the images view_depth and guide_normal.

const uint PATTERN_CENTRE = 16u, WHOLE_PATTERN = 511u, SIDES = 0x0aau;
const float OWN_PLANE_PX = 0.5;
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

// The nine bits of a pixel of the cell, and which of them are of receivers.
uvec2 bits_of(ivec2 offset) {
    uvec2 nine = uvec2(0u);
    for (int i = 0; i < 3; ++i) nine |= (uvec2(rows[offset.y + i], rows[offset.y + i] >> 16) >> uint(offset.x) & 7u) << 3 * i;
    return nine;
}

// Which of 3x3 pixels show the pixel's surface: the diagonal neighbours are asked, and stand for the sides next to them.
uint surface_seen(ivec2 p, ViewRays rays) {
    const uint AROUND[4] = uint[4](0x00bu, 0x026u, 0x0c8u, 0x1a0u);
    const vec3 n = decode_normal(imageLoad(guide_normal, p));
    const Surface own = surface_at(rays, n, imageLoad(view_depth, p).x, OWN_PLANE_PX);
    const ivec2 last = ivec2(frame.size) - 1;
    uint surface = WHOLE_PATTERN;
    for (int i = 0; i < 4; ++i) {
        const ivec2 q = clamp(p + diagonal(i), ivec2(0), last);
        if (!shows(own, vec2(q - p), imageLoad(view_depth, q).x)) surface &= ~AROUND[i];
    }
    return surface;
}

// Rays in the pixel's disc from which on the past is worth as much as the own ray where the edge is hard: where most of the
// pixels at its sides say the same, and where they do not. Frames that the own rays have gone undoubted for, from which on
// nothing moves there, by what the past is (shadow_state.glsl). All of them minimise the shots' error (docs/denoiser.md).
const float TESTS_WORTH_A_RAY = 0.19, TESTS_WORTH_AN_ODD_RAY = 0.04, UNMOVED[3] = float[3](1.0, 2.0, 9.0);

// What the past says of an edge is as good as the number of rays that have tested the pixel's own disc. Where that is much
// smaller than a pixel hardly any has, and what is there was resampled from pixels on either side of the edge. The own ray
// has: it is wrong only inside the penumbra, where such a pixel seldom lies, the less so if its sides agree with it.
// `frames`: that the past stands for; it gains less than they are, because what has been resampled goes on being resampled.
float trust_of_past(float tests, float frames, float unmoved, uint pattern) {
    const int lit = bitCount(pattern & SIDES), unlike = (pattern & PATTERN_CENTRE) != 0u ? 4 - lit : lit;
    const float tested = tests * sqrt(frames) * (1.0 + unmoved * unmoved * unmoved * unmoved);
    return tested / (tested + (unlike < 2 ? TESTS_WORTH_A_RAY : TESTS_WORTH_AN_ODD_RAY));
}
