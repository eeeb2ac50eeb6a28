// SPDX-License-Identifier: MIT
// Visibility as bits. A word holds 8x4 pixels, bit (y % 4) * 8 + x % 8; words are numbered along rows of the tile grid.
// In a ray-hit word 1 means occluded, in a visibility word 1 means lit, in a receiver word 1 means a surface is there.
// Per 8x8 pixels (two words, one above the other) the denoiser keeps a tile meta word.

const ivec2 TILE = ivec2(8, 4);
const ivec2 BLOCK = ivec2(8, 8);  // of a tile meta word

const uint BLOCK_WORK = 0u;      // pixels differ: the filters have work
const uint BLOCK_LIT = 1u;       // every pixel is 1 ...
const uint BLOCK_SHADOWED = 2u;  // ... or 0, and the filters know it without looking

ivec2 tile_grid(uvec2 image) { return (ivec2(image) + TILE - 1) / TILE; }
ivec2 tile_grid() { return tile_grid(frame.size); }
ivec2 block_grid() { return (ivec2(frame.size) + BLOCK - 1) / BLOCK; }

uint tile_index(ivec2 tile) { return uint(tile.y * tile_grid().x + tile.x); }
uint block_index(ivec2 block) { return uint(block.y * block_grid().x + block.x); }

uint pixel_bit(ivec2 p) { return 1u << uint((p.y & 3) * 8 + (p.x & 7)); }

// Buffers of a bit per tile hold 32 tiles of a row in a word.
uint tile_word(ivec2 tile, uvec2 image) { return uint(tile.y * (tile_grid(image).x + 31 >> 5) + (tile.x >> 5)); }
uint tile_word(ivec2 tile) { return tile_word(tile, frame.size); }
uint tile_bit(ivec2 tile) { return 1u << uint(tile.x & 31); }

// The previous frame's tile in the same place of the image: the same one, but where the size has changed.
ivec2 tile_before(ivec2 tile) {
    if (frame.size == frame.prev_size) return tile;
    const vec2 uv = (vec2(tile * TILE) + 0.5 * vec2(TILE)) / vec2(frame.size);
    return min(ivec2(uv * vec2(frame.prev_size)) / TILE, tile_grid(frame.prev_size) - 1);
}

// A tile's pixel for each of 32 lanes, in blocks of 4x2: the 8 lanes of a software device's subgroup walk a tree together.
ivec2 pixel_of_lane(int lane) { return ivec2((lane >> 3 & 1) * 4 + (lane & 3), (lane >> 4) * 2 + (lane >> 2 & 1)); }

// A tile's mask with the pixels numbered as lanes: pixel_of_lane() swaps bits 2 and 3 of an index.
uint lanes_of_pixels(uint mask) { return (mask & 0xF00FF00Fu) | (mask & 0x00F000F0u) << 4 | (mask & 0x0F000F00u) >> 4; }

// Index of the k-th set bit, from 0.
uint bit_number(uint word, uint k) {
    uint at = 0u;
    for (uint width = 16u; width != 0u; width >>= 1) {
        const uint below = uint(bitCount(word >> at & ((1u << width) - 1u)));
        if (k >= below) at += width;
        if (k >= below) k -= below;
    }
    return at;
}

// The bits of a tile that are pixels of the image.
uint inside_mask(ivec2 tile) {
    if (any(lessThan(tile, ivec2(0)))) return 0u;
    const ivec2 size = clamp(ivec2(frame.size) - tile * TILE, ivec2(0), TILE);
    const uint row = (1u << uint(size.x)) - 1u;
    const uint columns = row | row << 8 | row << 16 | row << 24;
    return size.y == 4 ? columns : columns & ((1u << uint(8 * size.y)) - 1u);
}
