// SPDX-License-Identifier: MIT
// Keeps the masks that were found anew for the next frames with this jitter: see reuse.comp. One lane per tile.
#include "node.glsl"
#include "common/tiles.glsl"
#include "common/reuse_words.glsl"

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tile_grid()))) return;
    const uint i = tile_index(tile);
    uint whole = (frame.flags & FRAME_RESET) == 0u ? whole_masks_prev[i] : 0u;
    if (reuse_words[i] == TO_KEEP) {
        const uint shared_pixels = uneven[i], mask = kept_mask(tile);
        bool left = false;
        for (uint w = 0u; w < SHARE_WORDS; ++w) {
            uint shares = 0u;
            for (uint k = 0u; k < 4u; ++k) {
                const uint pixel = 4u * w + k;
                if ((shared_pixels >> pixel & 1u) == 0u) continue;
                const float share = imageLoad(coverage, tile * TILE + ivec2(pixel & 7u, pixel >> 3)).x;
                left = left || share == 0.0;
                shares |= uint(share * 255.0 + 0.5) << 8u * k;
            }
            kept_masks[mask * SHARE_WORDS + w] = shares;
        }
        kept_hits[mask] = preloaded_hits[i];
        const uint own = 1u << kept_turn();
        whole = left ? whole & ~own : whole | own;
        count_kept(left ? 0u : 1u);
    }
    whole_masks[i] = whole;
}
