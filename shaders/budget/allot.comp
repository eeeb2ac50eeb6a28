// SPDX-License-Identifier: MIT
// How many rays each tile's pixels get, so that all of the frame's are worth the same and together as many as the budget has. Every
// workgroup finds the gain from which on rays are traced by itself, in the histogram that `worth` has made of the image.
#define APPENDS_TILES
#include "node.glsl"
#include "common/rounded.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#include "budget/ray_worth.glsl"
#include "budget/light_share.glsl"
#include "budget/tile_place.glsl"

// Of the gain that is just reached, the share of tiles that get their rays; the same ones as long as nothing moves.
struct Threshold {
    uint bin;
    float share;
};

uint wanted_at(uint bin) { return HAS_POOLED ? pooled[POOLED_GAINS + bin] : gains[bin]; }

// From the largest gain down; a lane sums up its part of the bins first, so that nobody goes through all of them.
const uint LANES = gl_WorkGroupSize.x * gl_WorkGroupSize.y, BINS_PER_LANE = GAIN_BINS / LANES;
shared uint wanted_by_part[LANES];

Threshold threshold() {
    const uint lane = gl_LocalInvocationIndex, top = GAIN_BINS - BINS_PER_LANE * lane;
    uint sum = 0u;
    for (uint i = 1u; i <= BINS_PER_LANE; ++i) sum += wanted_at(top - i);
    wanted_by_part[lane] = sum;
    group_barrier();
    uint left = ray_budget[0] - min(ray_budget[0], HAS_POOLED ? pooled[POOLED_FIRST_RAYS] : ray_budget[1]), part = 0u;
    while (part < LANES && wanted_by_part[part] <= left) left -= wanted_by_part[part++];
    if (part == LANES) return Threshold(0u, 1.0);
    uint bin = GAIN_BINS - BINS_PER_LANE * part - 1u;
    for (; wanted_at(bin) <= left; --bin) left -= wanted_at(bin);
    return Threshold(bin, max(float(left) / float(wanted_at(bin)), 1e-9));
}

void for_tile(ivec2 tile, Threshold t) {
    const bool in_grid = all(lessThan(tile, tile_grid()));
    const uvec4 pixels = in_grid ? classes[tile_index(tile)] : uvec4(0u);
    const uint steps_less = HAS_LIGHT_SHARES && in_grid ? light_shares[tile_index(tile)] : 0u;
    const bool chosen = place_of(tile) < t.share;
    // All of a subgroup or none: a list is appended to together.
    if (subgroupOr(pixels.x | pixels.y | pixels.z | pixels.w) != 0u)
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

void main() {
    const Threshold t = threshold();
    const uint rows = PER_THREAD_Y / uint(TILE.y);
    for (uint y = 0u; y < rows; ++y) for_tile(ivec2(gl_GlobalInvocationID.x, rows * gl_GlobalInvocationID.y + y), t);
}
