// SPDX-License-Identifier: MIT
// Which of a tile's pixels the previous frame showed among their like, where nothing can move: amid lit ones or amid shadowed ones.
//
// Includer has nearest_past.glsl and tiles.glsl and declares the image history.

const int ALONE_PX = 2;  // expected_error.glsl: from three pixels on unlike ones say nothing of a pixel

// Bit x: of any of x to x + 2 ALONE_PX.
uint any_across(uint row) {
    for (int i = 0; i < 2 * ALONE_PX; ++i) row |= row >> 1;
    return row;
}

// Bits of a tile's pixels. Who has no past is like anybody.
uint alone_pixels(ivec2 tile) {
    const ivec2 first = tile * TILE - ALONE_PX, last = ivec2(frame.prev_size) - 1;
    uint near_dark[4] = uint[4](0u, 0u, 0u, 0u), near_lit[4] = uint[4](0u, 0u, 0u, 0u), dark_here = 0u, lit_here = 0u;
    for (int y = 0; y < 4 + 2 * ALONE_PX; ++y) {
        uint dark = 0u, lit = 0u;
        for (int x = 0; x < 8 + 2 * ALONE_PX; ++x) {
            const uint word = imageLoad(history, clamp(first + ivec2(x, y), ivec2(0), last)).x;
            const float visibility = visibility_in(word);
            if (has_count(word) && visibility <= 1.0 - SURE_BELOW) dark |= 1u << x;
            if (has_count(word) && visibility >= SURE_BELOW) lit |= 1u << x;
        }
        const int row = y - ALONE_PX;
        if (row >= 0 && row < 4) {
            dark_here |= (dark >> ALONE_PX & 0xffu) << 8 * row;
            lit_here |= (lit >> ALONE_PX & 0xffu) << 8 * row;
        }
        dark = any_across(dark);
        lit = any_across(lit);
        for (int r = 0; r < 4; ++r)
            if (abs(row - r) <= ALONE_PX) {
                near_dark[r] |= dark & 0xffu;
                near_lit[r] |= lit & 0xffu;
            }
    }
    const uint by_dark = near_dark[0] | near_dark[1] << 8 | near_dark[2] << 16 | near_dark[3] << 24;
    const uint by_lit = near_lit[0] | near_lit[1] << 8 | near_lit[2] << 16 | near_lit[3] << 24;
    return lit_here & ~by_dark | dark_here & ~by_lit;
}
