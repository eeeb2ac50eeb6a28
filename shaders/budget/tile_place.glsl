// SPDX-License-Identifier: MIT
// A number from 0 to 1 for a tile, the same in every frame, by which tiles share what is not enough for all of them.
float place_of(ivec2 tile) {
    return float((uint(tile.x) * 3242174889u + uint(tile.y) * 2447445413u) >> 8) / 16777216.0;
}
