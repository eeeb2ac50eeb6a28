// SPDX-License-Identifier: MIT
// Tiles that a beam has proved lit or shadowed as a whole: they take no ray, and say what a ray of each pixel would.
//
// Includer has common/tiles.glsl and declares, perhaps, the buffer proved.
bool is_proved(ivec2 tile) {
    uint word = 0u;
    if (HAS_PROVED) word = proved[tile_word(tile)];
    return (word & tile_bit(tile)) != 0u;
}
