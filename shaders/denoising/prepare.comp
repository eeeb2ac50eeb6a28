// SPDX-License-Identifier: MIT
// Samples to visibility: lit = a receiver that no ray found occluded. One invocation per 8x4 word, of which
// every other one adds up what blocks in its 8x8 pixels.
#include "node.glsl"
#include "common/tiles.glsl"
#define READS_BLOCKERS
#include "common/blockers.glsl"

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
#if HAS_BLOCK_BLOCKERS
    if ((tile.y & 1) == 0) {
        vec3 sums = blockers_of(tile_index(tile));
        if (tile.y + 1 < tile_grid().y) sums += blockers_of(tile_index(tile + ivec2(0, 1)));
        store_block_blockers(ivec2(tile.x, tile.y / 2), vec4(sums, 0.0));
    }
#endif
}
