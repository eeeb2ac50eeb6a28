// SPDX-License-Identifier: MIT
// Rows of bits that run across tiles.

// 24 pixels of row `row` of a tile and of its neighbours; bit 0 is 8 pixels left of the tile's first.
uint row_of(uvec3 words, int row) {
    const uvec3 bytes = words >> uint(8 * row) & 0xffu;
    return bytes.x | bytes.y << 8 | bytes.z << 16;
}
