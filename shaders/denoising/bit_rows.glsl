// SPDX-License-Identifier: MIT
// The bits of a cell's pixels and of those up to R around, as rows: what this frame's rays say, and of which pixels. Every
// index is known when this is compiled, where it can be: software devices store to one that is not lane by lane.
//
// Includer has tiles.glsl and shadow_state.glsl, defines the constant R and declares the buffers visibility_words, sunward_words and,
// where not every pixel that looks at the sun has a ray, ray_words, and known, where the past is as good as a ray.

#include "common/tile_rows.glsl"

const int ROWS = CELL + 2 * R;
const uint ROW_COLUMNS = (1u << uint(ROWS)) - 1u;  // a row is as long as there are rows
const int TILES_ABOVE = (R + TILE.y - 1) / TILE.y;

// Which pixels' bits tell their neighbours something, and which of them are lit. What has long said one thing and cannot change says it
// without a ray: a neighbourhood that is whole in every frame is worth more than one with gaps that come and go (docs/budget.md).
uvec2 said_by_tile(uint tile) {
    uint tested = sunward_words[tile], lit = visibility_words[tile];
    if (HAS_RAY_WORDS) {
        uvec4 past = uvec4(0u);
        if (HAS_KNOWN) past = known[tile];
        const uint rays = ray_words[tile];
        tested &= rays | past.w;
        lit = lit & rays | past.z & ~rays;
    }
    return uvec2(tested, lit & tested);
}

// Of the pixels themselves: who has a ray or a proof in this frame.
bool has_ray(ivec2 p) {
    const uint tile = tile_index(p / TILE);
    uint rays = sunward_words[tile];
    if (HAS_RAY_WORDS) rays &= ray_words[tile];
    return (rays & pixel_bit(p)) != 0u;
}

// Lit pixels in the lower 16 bits, and in the upper ones those of which that is known. Bit 0 is R pixels left of the cell, the
// first row R above it.
uint rows[ROWS];

void load_tiles(ivec2 cell, const int first) {
    const ivec2 tile = ivec2(cell.x >> 1, cell.y), grid = tile_grid();
    const uint column = uint(8 + (cell.x * CELL & 7) - R);  // from the left tile on
    [[unroll]] for (int ty = first; ty <= TILES_ABOVE; ++ty) {
        uvec3 lit, tested;
        [[unroll]] for (int tx = 0; tx < 3; ++tx) {
            const ivec2 at = tile + ivec2(tx - 1, ty), inside = clamp(at, ivec2(0), grid - 1);
            const uvec2 said = at == inside ? said_by_tile(tile_index(inside)) : uvec2(0u);
            tested[tx] = said.x;
            lit[tx] = said.y;
        }
        [[unroll]] for (int y = max(0, -R - TILE.y * ty); y < min(TILE.y, ROWS - R - TILE.y * ty); ++y)
            rows[TILE.y * ty + y + R] = row_of(lit, y) >> column & ROW_COLUMNS |
                                        (row_of(tested, y) >> column & ROW_COLUMNS) << 16;
    }
}

void load_rows(ivec2 cell) { load_tiles(cell, -TILES_ABOVE); }

// The same, where the rows of the cell above have been loaded.
void load_rows_below(ivec2 cell) {
    [[unroll]] for (int i = 0; i < ROWS - CELL; ++i) rows[i] = rows[i + CELL];
    load_tiles(cell, R / TILE.y);  // the first that has a new row, which is R below the cell above
}

bool is_lit(ivec2 in_rows) { return (rows[in_rows.y] & 1u << uint(in_rows.x)) != 0u; }
bool is_tested(ivec2 in_rows) { return (rows[in_rows.y] & 0x10000u << uint(in_rows.x)) != 0u; }

// What a row says: its lit pixels in the lower half, its dark ones in the upper half.
uint said_by(uint row) { return row ^ row << 16; }

bool has_both(uint said) { return (said & 0xffffu) != 0u && said > 0xffffu; }

// By the cell's pixels and those up to `reach` around.
uint said_within(const int reach) {
    uint said = 0u;
    [[unroll]] for (int i = R - reach; i < R + CELL + reach; ++i) said |= said_by(rows[i]);
    const uint columns = ((1u << uint(CELL + 2 * reach)) - 1u) << uint(R - reach);
    return said & (columns | columns << 16);
}

// A tile word's pixels that are a cell's; pixel (x, y) is bit 4 y + x.
uint pixels_of_cell(uint word, ivec2 cell) {
    const uint half_tile = word >> uint(cell.x * CELL & 7);
    return half_tile & 0xfu | half_tile >> 4 & 0xf0u | half_tile >> 8 & 0xf00u | half_tile >> 12 & 0xf000u;
}

// Those with both lit and dark ones up to R away.
uint pixels_with_both() {
    uint pixels = 0u;
    [[unroll]] for (int y = 0; y < CELL; ++y) {
        uint said = 0u;
        [[unroll]] for (int i = 0; i <= 2 * R; ++i) said |= said_by(rows[y + i]);
        [[unroll]] for (int x = 0; x < CELL; ++x) {
            const uint columns = ((2u << uint(2 * R)) - 1u) << uint(x);
            if (has_both(said & (columns | columns << 16))) pixels |= 1u << uint(CELL * y + x);
        }
    }
    return pixels;
}
