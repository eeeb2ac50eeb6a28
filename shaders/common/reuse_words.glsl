// SPDX-License-Identifier: MIT
// Masks that frames keep for later ones. A camera that stands still is jittered, by the same sixteen offsets again and again, so a mask
// is the next one's but fifteen: each of sixteen frames in turn has a place of its own.
//
// Includer has common/tiles.glsl.

const uint JITTERS = 16u;
uint kept_turn() { return frame.frame_index % JITTERS; }

// Of a tile in this frame.
const uint NOT_KEPT = 0u;  // to be found anew, or there is nothing to find
const uint REUSED = 1u;    // `kept_masks` has it
const uint TO_KEEP = 2u;   // to be found anew and kept

// A tile's mask of a frame: the shares of 32 pixels as `coverage` has them, four in a word of `kept_masks`, and a word of `kept_hits`.
const uint SHARE_WORDS = 8u;
uint kept_mask(ivec2 tile) {
    const ivec2 grid = tile_grid();
    return kept_turn() * uint(grid.x * grid.y) + tile_index(tile);
}
