// SPDX-License-Identifier: MIT
// What nine shadow rays say together. A pixel's own bit is right on average and far off in every single case; the bits of
// 3x3 pixels on one surface show where an edge runs through them and how soft it is. The table (nodes/edge_patterns.cpp)
// holds the centre's expected visibility for each of the 512 patterns: a third of the ray's squared error in a penumbra of
// one pixel, a quarter at two. It is biased where an edge is not what the table expects, so it never enters the history.
//
// Includer has common/bit_window.glsl and the table `edge_patterns` (r8, 32 x 16).

const uint PATTERN_CENTRE = 16u, WHOLE_PATTERN = 511u;

// Row by row; a pixel that is not of `surface` (a bit for each of the nine) or receives nothing says what the centre says.
uint edge_pattern(Surroundings around, int column, int j, uint surface) {
    uint lit = 0u, receivers = 0u;
    for (int i = 0; i < 3; ++i) {
        const int y = 7 + j + i;
        lit |= (row_of(around.lit[y >> 2], y & 3) >> (column + 7) & 7u) << 3 * i;
        receivers |= (row_of(around.receivers[y >> 2], y & 3) >> (column + 7) & 7u) << 3 * i;
    }
    const uint known = receivers & surface;
    return (lit & PATTERN_CENTRE) != 0u ? lit | ~known & WHOLE_PATTERN : lit & known;
}

float visibility_by_pattern(uint pattern) {
    return texelFetch(edge_patterns, ivec2(pattern & 31u, pattern >> 5), 0).x;
}
