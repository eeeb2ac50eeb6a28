// SPDX-License-Identifier: MIT
// Who need not be asked again. Where neither the sun nor anything that casts a shadow moves, a point of a surface is as lit as it was: a
// pixel whose point the previous frame showed amid light still is. Amid light: in a whole tile, and REACH pixels around it, nothing
// was in penumbra or in shadow. A shadow smaller than that, of which no pixel had seen anything, is met in its turn.
// Shadow is not remembered: points at the end of a surface that faces away lie amid shadow as well, and may be lit.
#define APPENDS_TILES
#include "node.glsl"
#include "common/camera.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#include "common/reuse_words.glsl"

const int REACH = 2;            // px
const float SAME_DEPTH = 0.03;  // relative: half a pixel of a surface that is seen at a grazing angle

// Whether the previous frame's pixels from `first` to `last` were lit, or sky; false beyond its border.
bool were_lit(ivec2 first, ivec2 last) {
    const ivec2 grid = tile_grid(frame.prev_size), from = first >> ivec2(3, 2), to = last >> ivec2(3, 2);
    if (any(lessThan(first, ivec2(0))) || any(greaterThanEqual(last, ivec2(frame.prev_size)))) return false;
    uint unlit = 0u;
    for (int y = from.y; y <= to.y; ++y)
        for (int x = from.x; x <= to.x; ++x) {
            const uint at = uint(y * grid.x + x);
            const ivec2 low = max(first - ivec2(x, y) * TILE, ivec2(0)), high = min(last - ivec2(x, y) * TILE, TILE - 1);
            const uint row = (0xffu << low.x & 0xffu >> 7 - high.x) * 0x01010101u, rows = ~0u << 8 * low.y & ~0u >> 8 * (3 - high.y);
            if (HAS_REUSE_WORDS_PREV)
                if (reuse_words_prev[at] == REUSED) unlit |= row & rows;
            unlit |= (receiver_words_prev[at] & hits_prev[at] | uneven_prev[at]) & row & rows;
        }
    return unlit == 0u;
}

// Where the previous frame showed a pixel's point; false: nowhere, or something else was there.
bool pixel_before(ivec2 p, out ivec2 there) {
    there = p;
    if (!HAS_MOTION) return pixels_have_pasts();
    const Reprojection before = reproject(p, texelFetch(motion, p, 0).xy);
    there = previous_texel(before.uv);
    const float expected = previous_depth(position(p, imageLoad(view_depth, p).x));
    return before.on_screen && abs(imageLoad(view_depth_prev, there).x - expected) <= SAME_DEPTH * expected;
}

// Pixels of the tile that were amid light. What lay around the tile is looked up where the first of its pixels came from; who came from
// elsewhere than beside that is asked.
uint amid_light(ivec2 tile, uint pixels) {
    const int first = findLSB(pixels);
    const ivec2 corner = tile * TILE, guide = corner + ivec2(first & 7, first >> 3);
    ivec2 there;
    if (!pixel_before(guide, there)) return 0u;
    const ivec2 shift = there - guide;
    if (!were_lit(corner + shift - REACH, corner + shift + TILE - 1 + REACH)) return 0u;
    uint lit = 0u;
    for (int i = 0; i < 32; ++i)
        if ((pixels >> i & 1u) != 0u) {
            const ivec2 p = corner + ivec2(i & 7, i >> 3);
            const bool known = pixel_before(p, there);
            if (known && all(lessThan(abs(there - p - shift), ivec2(REACH)))) lit |= 1u << i;
        }
    return lit;
}

// Tiles of a row by eights: most often they are the lanes of a subgroup, which waits for the slowest of them.
bool in_its_turn(ivec2 tile) { return (uint(tile.x >> 3) + uint(tile.y) * 5u + frame.frame_index) % params.turn == 0u; }

void main() {
    const uint index = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    uvec4 record = uvec4(0u);
    if (index < candidate_args[3]) record = candidates[index];
    const ivec2 tile = tile_of(record);
    uint lit = 0u;
    if (record.y != 0u && (frame.flags & FRAME_RESET) == 0u && !in_its_turn(tile)) lit = amid_light(tile, record.y);
    record.y &= ~lit;
    append_tile(record.y != 0u, record);
    count_lit(uint(bitCount(lit)));
    count_left(uint(bitCount(record.y)));
}
