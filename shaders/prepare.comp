// SPDX-License-Identifier: MIT
// Ray hits to visibility: lit = a receiver that no ray found occluded. One invocation per 8x4 word.
#include "node.glsl"
#include "common/tiles.glsl"

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tile_grid()))) return;
    const uint i = tile_index(tile);
    visibility_words[i] = ~hits[i] & receiver_words[i];
}
