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
#include "budget/ray_worth.glsl"
#include "budget/light_share.glsl"
#include "budget/first_rays.glsl"
#include "budget/tile_place.glsl"
#include "budget/proved_tile.glsl"

const float FOR_THE_UNSURE = 0.8;  // of a budget that does not reach for all
const float LEAST_SHARE = 0.03125;   // a pixel of a tile

// The i-th pixel of a tile to be asked: neighbours' turns lie far apart. Bits of i from the lowest on: x 2, y 1, x 1, y 0, x 0.
uint bit_in_turn(uint i) {
    return (i & 1u) << 2 | (i >> 1 & 1u) << 4 | (i >> 2 & 1u) << 1 | (i >> 3 & 1u) << 3 | i >> 4 & 1u;
}

// By how many places the turns go on from frame to frame. By as many pixels as are asked, nobody waits for longer than 32 / count frames, rounded
// up; but a pixel's frames go round then in nearly the same rhythm as its points of the sun do for some counts (19 / 32 and NOISE_STEP's .585),
// and all of its rays see one part of it. Seven goes together with none of them, and nobody waits for more than five frames (docs/budget.md).
const uint TURN_STEP = 7u;
uint step_of_turns(uint count) { return count > 8u ? TURN_STEP : count; }

// A share of a tile's pixels, in 32nds.
uint turn(uint count) {
    uint pixels = count >= 32u ? ~0u : 0u;
    for (uint i = 0u; i < (count >= 32u ? 0u : count); ++i) pixels |= 1u << bit_in_turn(i + step_of_turns(count) * frame.frame_index & 31u);
    return pixels;
}

// Where there is enough a share is rounded down, and everyone's turn comes within a known number of frames. Else it is `counted`: pixels of a kind
// are often those that were not asked before, whose turn it is, or those that were, and the least shares of several lights would be none for
// good. Then a tile is rounded up as often as it takes.
// `kind`: so that a tile is not rounded up for all of them at once.
uint asked_of(uint kind, uint pixels, float share, ivec2 tile, bool counted) {
    const float in_32nds = clamp(32.0 * share, 0.0, 32.0);
    if (!counted) return pixels & turn(rounded(floor(in_32nds)));
    const float up = fract(place_of(tile) + 0.618034 * float(frame.frame_index & 0xffffu) + float(kind) / 3.0);
    const uint wanted = rounded(floor(float(bitCount(pixels)) * min(share, 1.0) + up)), first = step_of_turns(max(rounded(in_32nds), 1u)) * frame.frame_index;
    uint asked = 0u;
    for (uint i = 0u, count = 0u; i < 32u && count < wanted; ++i) {
        const uint bit = pixels & 1u << bit_in_turn(i + first & 31u);
        if (bit != 0u) ++count;
        asked |= bit;
    }
    return asked;
}

uint sunward_in(ivec2 tile) {
    return any(lessThan(tile, ivec2(0))) || any(greaterThanEqual(tile, tile_grid())) ? 0u : sunward_words[tile_index(tile)];
}

// Pixels of a tile next to which no receiver is seen, or nothing: what comes from there had no ray before.
uint beside_others(ivec2 tile, uint sunward) {
    const uint left = sunward_in(tile - ivec2(1, 0)), right = sunward_in(tile + ivec2(1, 0));
    const uint above = sunward_in(tile - ivec2(0, 1)), below = sunward_in(tile + ivec2(0, 1));
    const uint from_left = (sunward & 0x7f7f7f7fu) << 1 | (left & 0x80808080u) >> 7, from_right = (sunward & 0xfefefefeu) >> 1 | (right & 0x01010101u) << 7;
    return ~(from_left & from_right & (sunward << 8 | above >> 24) & (sunward >> 8 | below << 24));
}

// What each kind of pixel gets.
struct Shares {
    float budget;               // rays
    float of_unsure, of_others; // factors of a light's weight, or WHOLE
    bool enough, for_everyone, one_first;
};

Shares shares_of_the_budget() {
    float unsure[SHARE_CLASSES], rest[SHARE_CLASSES], first = 0.0, others = 0.0, pixels_of_all = 0.0;
    for (uint c = 0u; c < SHARES; ++c) {
        unsure[c] = pixels_that_are(UNSURE, c);
        rest[c] = pixels_that_are(OTHERS, c) + params.trickle * pixels_that_are(IDLE, c);
        first += unsure[c] + rest[c];
        others += pixels_that_are(OTHERS, c);
        pixels_of_all += unsure[c] + pixels_that_are(OTHERS, c) + pixels_that_are(IDLE, c);
    }
    Shares s;
    s.budget = params.rays_per_frame * (pixels_of_all + float(HAS_POOLED ? 0u : pixel_counts[PROVED_PIXELS]));
    s.enough = s.budget >= first;
    s.for_everyone = HAS_SUNWARD_WORDS && s.budget >= pixels_of_all;
    const float tiles = float(candidate_args[3]);
    // Tiles are rounded up and down, and some more of them up in one frame than in another: rays that are kept for that.
    const float dealt = s.enough || HAS_POOLED ? s.budget : max(s.budget - sqrt(tiles), 0.0);
    s.of_unsure = s.enough ? WHOLE : factor_for(FOR_THE_UNSURE * dealt, unsure);
    const float left = dealt - cast_by(s.of_unsure, unsure);
    s.of_others = s.enough ? WHOLE : factor_for(left, rest);
    // Less than a pixel of a tile would be none: then one comes first, if there are as many rays as tiles.
    s.one_first = !HAS_POOLED && params.trickle > 0.0 && params.trickle * min(s.of_others, 1.0) < LEAST_SHARE && left >= tiles;
    if (s.one_first) s.of_others = (left - tiles) / max(others, 1.0);
    return s;
}

uint asked_in(ivec2 tile, uint candidates_here, Shares s) {
    const uvec4 tile_known = known[tile_index(tile)];
    const float weight = HAS_LIGHT_SHARES ? weight_of(share_class(light_shares[tile_index(tile)])) : 1.0;
    const float others_here = min(s.of_others * weight, 1.0), idle_here = s.one_first ? LEAST_SHARE : params.trickle * others_here;
    const bool counted = HAS_POOLED || !s.enough;
    const uint idle = tile_known.y & ~(s.for_everyone ? beside_others(tile, candidates_here) : 0u);
    return asked_of(UNSURE, candidates_here & tile_known.x, s.of_unsure * weight, tile, counted) |
           asked_of(IDLE, candidates_here & idle, idle_here, tile, counted && !s.one_first) |
           asked_of(OTHERS, candidates_here & ~(tile_known.x | idle), others_here, tile, counted);
}

void main() {
    uvec4 record = uvec4(0u);
    const uint index = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (index < candidate_args[3]) record = candidates[index];
    uint pixels = 0u;
    const ivec2 tile = tile_of(record);
    const bool proof = record.y != 0u && is_proved(tile);
    if (proof) ray_words[tile_index(tile)] = record.y;
    if (index == 0u || record.y != 0u && !proof) {
        const Shares shares = shares_of_the_budget();
        if (index == 0u) ray_budget[0] = uint(min(shares.budget, 4294967040.0));
        if (record.y != 0u && !proof) {
            pixels = asked_in(tile, record.y, shares);
            ray_words[tile_index(tile)] = pixels;
        }
    }
    const uint rays = subgroupAdd(uint(bitCount(pixels)));
    if (subgroupElect() && rays != 0u) atomicAdd(ray_budget[1], rays);
    count_sunward(uint(bitCount(record.y)));
    append_tile(pixels != 0u, uvec4(record.x, pixels, record.zw));
}
