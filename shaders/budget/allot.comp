// SPDX-License-Identifier: MIT
// How many rays each tile's pixels get, so that all of the frame's are worth the same and together as many as the budget has. Every
// invocation finds the gain from which on rays are traced by itself, in the histogram that `worth` has made of the image.
#define APPENDS_TILES
#include "node.glsl"
#include "common/rounded.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#include "common/branch.glsl"
#include "budget/ray_worth.glsl"
#include "budget/light_share.glsl"
#include "budget/tile_place.glsl"

// Of the gain that is just reached, the share of tiles that get their rays; the same ones as long as nothing moves.
struct Threshold {
    uint bin;
    float share;
};

Threshold threshold() {
    const uint first_rays = HAS_POOLED ? pooled[POOLED_FIRST_RAYS] : ray_budget[1];
    float left = float(ray_budget[0] - min(ray_budget[0], first_rays));
    uint bin = GAIN_BINS;
    float share = 0.0;
    while (bin > 0u && share == 0.0) {
        const float wanted = float(HAS_POOLED ? pooled[POOLED_GAINS + bin - 1u] : gains[bin - 1u]);
        --bin;
        if (wanted > left) share = max(left / wanted, 1e-9);
        left -= wanted;
    }
    return Threshold(bin, share == 0.0 ? 1.0 : share);
}

void main() {
    const Threshold t = threshold();
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    const bool in_grid = all(lessThan(tile, tile_grid()));
    const uvec4 pixels = in_grid ? classes[tile_index(tile)] : uvec4(0u);
    const uint steps_less = HAS_LIGHT_SHARES && in_grid ? light_shares[tile_index(tile)] : 0u;
    const bool chosen = place_of(tile) < t.share;
    for (uint c = 0u; c < CLASSES; ++c) {
        uint level = 0u;
        if (pixels[c] != 0u)
            for (uint i = 0u; i + 1u < LEVELS; ++i) {
                const uint bin = gain_bin(EXPECTED[c], i, steps_less);
                if (bin > t.bin || bin == t.bin && chosen) level = i + 1u;
            }
        append_tile(level != 0u, with_rays(pack_tile(tile, pixels[c], 0.0, WHOLE_RAY_M), RAYS_AT[level]));
        count_allotted(uint(bitCount(pixels[c])) * (RAYS_AT[level] - 1u));
    }
}
