// SPDX-License-Identifier: MIT
// Samples to visibility: lit = a receiver that no ray found occluded. One invocation per 8x4 word.
#include "node.glsl"
#include "common/tiles.glsl"

uint lit_pixels(ivec2 tile) {
    uint lit = 0u;
    if (HAS_HITS) lit = ~hits[tile_index(tile)];
    if (!HAS_MASK) return lit;
    const uint pixels = inside_mask(tile);
    for (int i = 0; i < 32; ++i)  // a comparison that a NaN fails: no sample is no light
        if ((pixels >> i & 1u) != 0u && texelFetch(mask, tile * TILE + ivec2(i & 7, i >> 3), 0).x > 0.5) lit |= 1u << i;
    return lit;
}

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tile_grid()))) return;
    visibility_words[tile_index(tile)] = lit_pixels(tile) & receiver_words[tile_index(tile)];
}
