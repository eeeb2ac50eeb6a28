// SPDX-License-Identifier: MIT
// Receiver words from the depth alone. One invocation per 8x4 word.
#include "node.glsl"
#include "common/tiles.glsl"

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tile_grid()))) return;
    const uint pixels = inside_mask(tile);
    uint receivers = 0u;
    for (int i = 0; i < 32; ++i)
        if ((pixels >> i & 1u) != 0u && imageLoad(view_depth, tile * TILE + ivec2(i & 7, i >> 3)).x > 0.0)
            receivers |= 1u << i;
    receiver_words[tile_index(tile)] = receivers;
}
