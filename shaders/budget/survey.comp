// SPDX-License-Identifier: MIT
// What the previous frame knew of the pixels that could have a ray: which of them it cannot be asked about, because they are new or were
// in penumbra, and which lie where all rays said the same. And how many there are of either, for whoever has a budget to keep.
#define LISTED_TILES candidates
#define LISTED_ARGS candidate_args
#include "node.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/corners.glsl"
#include "common/rounded.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
const bool MANY_RAYS = true;
#include "common/dithered.glsl"
#include "common/own_rays.glsl"
#include "common/shadow_state.glsl"
#include "common/cell_before.glsl"
#include "common/sun_change.glsl"
#include "common/another_sun.glsl"
#include "budget/nearest_place.glsl"
#include "budget/nearest_past.glsl"
#include "budget/alone.glsl"
#include "budget/ray_worth.glsl"
#include "budget/light_share.glsl"
#include "budget/proved_tile.glsl"

const float NEVER_ELSE = 0.003;  // of 0 or of 1: less than one ray among those that a past stands for
const bool NOTHING_MOVES = !HAS_MOTION && !HAS_SUN_PREV && !HAS_LIGHT_PREV;
const float SETTLED = 24.0;  // frames after which, where nothing can move, a pixel that was never in penumbra needs no more than its turn

// Pixels that are new or were in penumbra; none; those that were lit; those that have long been lit or shadowed and cannot change.
// `at_steps`: those whose past is taken from beside a step, and may be at its foot now.
uvec4 by_their_past(ivec2 tile, uint pixels, out uint at_steps) {
    at_steps = 0u;
    if ((frame.flags & FRAME_RESET) != 0u || is_another_sun()) return uvec4(pixels, 0u, 0u, 0u);
    uvec4 masks = uvec4(0u);
    uint soon = 0u;
    ViewRays before;
    if (HAS_MOTION) before = previous_rays(mat3(1.0));
    for (int i = 0; i < 32; ++i) {
        const PixelPast past = nearest_past(tile * TILE + ivec2(i & 7, i >> 3), before);
        const float between = min(past.visibility, 1.0 - past.visibility);
        if (!past.known || between >= SURE_BELOW) masks.x |= 1u << i;
        if (NOTHING_MOVES && past.known && between < NEVER_ELSE) {
            if (past.count >= SETTLED) masks.w |= 1u << i;
            if (past.count >= ALONE_FRAMES) soon |= 1u << i;
        }
        if (past.visibility > 0.5) masks.z |= 1u << i;
        if (past.beside_step) at_steps |= 1u << i;
    }
    soon &= pixels & ~masks.w;
    if (soon != 0u) masks.w |= soon & alone_pixels(tile);
    return masks & pixels;
}

// Was the cell that the previous frame showed there, and whatever was within gather's reach of it, of one kind?
bool was_idle(ivec2 cell) {
    const ivec2 last = ivec2(frame.prev_size) - 1;
    ivec2 there;
    if (is_another_sun() || !cell_before(cell * CELL, there)) return false;
    bool idle = true;
    for (int i = 0; i < 4; ++i)
        idle = idle && is_idle(idle_word(idle_cells_prev[cell_index(clamp(there + (CELL - 1) * corner(i), ivec2(0), last) / CELL, frame.prev_size)]));
    return idle;
}

void main() {
    const uint index = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    uvec4 record = uvec4(0u);
    if (index < candidate_args[3]) record = candidates[index];
    uvec4 masks = uvec4(0u);
    uint share = 0u, proved_pixels = 0u;
    if (record.y != 0u) {
        const ivec2 tile = tile_of(record), cell = ivec2(2 * tile.x, tile.y);
        const bool proof = is_proved(tile);
        if (proof) {
            masks = uvec4(0u, record.y, 0u, record.y);
            proved_pixels = uint(bitCount(record.y));
        } else {
            uint at_steps;
            masks = by_their_past(tile, record.y, at_steps);
            const uint cells = (was_idle(cell) ? 0x0f0f0f0fu : 0u) | (was_idle(cell + ivec2(1, 0)) ? 0xf0f0f0f0u : 0u);
            const uint sure = record.y & ~masks.x, lit = sure & masks.z;
            // Pasts that are unlike come from different places; and where there was light a step's foot may be dark.
            const uint idle = lit == 0u || lit == sure ? sure & cells & ~(lit & at_steps) : 0u;
            masks.y = idle | masks.w;
        }
        known[tile_index(tile)] = masks;
#if HAS_SHARE_STEPS
        const uint steps = HAS_TILE_LUX ? steps_of_share(tile_lux[tile_index(tile)], lux_of_all[tile_index(tile)]) : 0u;
        share_steps[tile_index(tile)] = steps;
        share = share_class(steps);
#endif
    }
    const uvec3 counts = uvec3(bitCount(masks.x), bitCount(record.y & ~masks.x & ~masks.y), bitCount(masks.y) - proved_pixels);
    const uint decided = subgroupAdd(proved_pixels);
    if (subgroupElect() && decided != 0u) atomicAdd(pixel_counts[PROVED_PIXELS], decided);
    // None where a subgroup has no tile, as most have of one light of many. A loop, since Mesa 22 walks through branches in any case.
    const uint counted = subgroupOr(record.y) == 0u ? 0u : HAS_TILE_LUX ? SHARE_CLASSES : 1u;
    for (uint c = 0u; c < counted; ++c)
        for (uint i = 0u; i < 3u; ++i) {
            const uint n = subgroupAdd(share == c ? counts[i] : 0u);
            if (subgroupElect() && n != 0u) atomicAdd(pixel_counts[3u * c + i], n);
        }
}
