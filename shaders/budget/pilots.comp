// SPDX-License-Identifier: MIT
// Which pixels get a first ray in this frame. Where the previous frame's rays all said the same, a few pixels of each tile will do; the
// others' turn comes, so that all have one within a stated number of frames. Elsewhere every pixel has one, as far as the
// budget goes: first those of which nothing is known, then those near them. What is not spent here is allotted where it is worth most.
#define APPENDS_TILES
#define LISTED_TILES candidates
#define LISTED_ARGS candidate_args
#include "node.glsl"
#include "common/rounded.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#include "common/branch.glsl"

const float FOR_THE_UNSURE = 0.8;  // of a budget that does not reach for all
const float LEAST_SHARE = 0.03125;   // a pixel of a tile

// The i-th pixel of a tile to be asked: neighbours' turns lie far apart. Bits of i from the lowest on: x 2, y 1, x 1, y 0, x 0.
uint bit_in_turn(uint i) {
    return (i & 1u) << 2 | (i >> 1 & 1u) << 4 | (i >> 2 & 1u) << 1 | (i >> 3 & 1u) << 3 | i >> 4 & 1u;
}

// A share of a tile's pixels, in 32nds: all of them within 32 / count frames, rounded up.
uint turn(uint count) {
    uint pixels = count >= 32u ? ~0u : 0u;
    for (uint i = 0u; i < (count >= 32u ? 0u : count); ++i) pixels |= 1u << bit_in_turn(i + count * frame.frame_index & 31u);
    return pixels;
}

uint in_32nds(float share) { return rounded(floor(clamp(32.0 * share, 0.0, 32.0))); }

void main() {
    const float unsure = float(pixel_counts[0]), others = float(pixel_counts[1]), idle = float(pixel_counts[2]);
    const float budget = params.rays_per_frame * (unsure + others + idle);
    const bool enough = budget >= unsure + others + params.trickle * idle;
    const float of_unsure = enough ? 1.0 : min(FOR_THE_UNSURE * budget / max(unsure, 1.0), 1.0);
    const float left = budget - of_unsure * unsure;
    float of_others = enough ? 1.0 : min(left / max(others + params.trickle * idle, 1.0), 1.0);
    float of_idle = params.trickle * of_others;
    // Less than a pixel of a tile would be none: then one comes first, if there are as many rays as tiles.
    const float tiles = float(candidate_args[3]);
    if (params.trickle > 0.0 && of_idle < LEAST_SHARE && left >= tiles) {
        of_idle = LEAST_SHARE;
        of_others = min((left - tiles) / max(others, 1.0), 1.0);
    }

    uvec4 record = uvec4(0u);
    const uint index = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (index < candidate_args[3]) record = candidates[index];
    uint pixels = 0u;
    BRANCH_IF (record.y != 0u) {
        const uvec4 tile_known = known[tile_index(tile_of(record))];
        pixels = record.y & (tile_known.x & turn(in_32nds(of_unsure)) | tile_known.y & turn(in_32nds(of_idle)) |
                             ~(tile_known.x | tile_known.y) & turn(in_32nds(of_others)));
        ray_words[tile_index(tile_of(record))] = pixels;
    }
    const uint rays = subgroupAdd(uint(bitCount(pixels)));
    if (subgroupElect() && rays != 0u) atomicAdd(ray_budget[1], rays);
    if (index == 0u) ray_budget[0] = uint(min(budget, 4294967040.0));
    count_sunward(uint(bitCount(record.y)));
    append_tile(pixels != 0u, uvec4(record.x, pixels, record.zw));
}
