// SPDX-License-Identifier: MIT
// What nine shadow rays say together. A pixel's own bit is right on average and far off in every single case; the bits of
// 3x3 pixels on one surface show where an edge runs through them and how soft it is. The table (nodes/edge_patterns.cpp)
// holds the centre's expected visibility for each of the 512 patterns: a third of the ray's squared error in a penumbra of
// one pixel, a quarter at two. It is biased where an edge is not what the table expects, so it never enters the history.
//
// Includer has common/camera.glsl, guide_normal.glsl, previous_surface.glsl, the images view_depth and guide_normal, and the
// table `edge_patterns` (r8, 32 x 16).

const uint PATTERN_CENTRE = 16u, WHOLE_PATTERN = 511u;
const float OWN_PLANE_PX = 0.5;
const float LEAST_SHARE = 1.0 / 64.0;  // of the pattern: less is not worth asking nine pixels' surface
const float CONVERGENCE = 1.75;        // of an average of rays: variance ~ n^-1.75, chosen by what accumulate's filters gain

// Nine bits each, row by row. A pixel that is not `known`, because it is of another surface or receives nothing, says what
// the centre says.
uint edge_pattern(uint lit, uint known) {
    return (lit & PATTERN_CENTRE) != 0u ? lit | ~known & WHOLE_PATTERN : lit & known;
}

float visibility_by_pattern(uint pattern) {
    return texelFetch(edge_patterns, ivec2(pattern & 31u, pattern >> 5), 0).x;
}

// Which of 3x3 pixels show the centre's surface: the diagonal neighbours are asked, and stand for the sides next to them.
uint surface_around(ivec2 p) {
    const uint CORNERS[4] = uint[4](0x00bu, 0x026u, 0x0c8u, 0x1a0u);
    const float z = imageLoad(view_depth, p).x, tolerance_m = OWN_PLANE_PX * pixel_span_m(z);
    const vec3 here = position(p, z), n = decode_normal(imageLoad(guide_normal, p));
    const ivec2 last = ivec2(frame.size) - 1;
    uint surface = WHOLE_PATTERN;
    for (int i = 0; i < 4; ++i) {
        const ivec2 q = clamp(p + 2 * ivec2(i & 1, i >> 1) - 1, ivec2(0), last);
        if (!lies_on_plane(position(q, imageLoad(view_depth, q).x), here, n, tolerance_m)) surface &= ~CORNERS[i];
    }
    return surface;
}

// How much the pattern of bits counts beside an average over `frames` of some rays each, whose variance falls as the frames'
// -CONVERGENCEth power.
float share_of_pattern(float frames, float rays, float pattern_samples) {
    return pattern_samples / (pattern_samples + rays * pow(frames, CONVERGENCE) - 1.0 + 1e-6);
}
