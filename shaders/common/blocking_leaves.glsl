// SPDX-License-Identifier: MIT
// What blocked a tile's rays in the frame before: up to four leaves of the tree, each as its index + 1, 0 = none. A shadow
// ray asks whether anything is in its way, so one leaf that is answers it without a walk, and which one is tried first
// changes no answer: a leaf that is stale, or no leaf at all, costs a test. The shadow cache of Haines and Greenberg 1986,
// "The Light Buffer: A Shadow-Testing Accelerator", per tile and over time.
//
// Includer declares: buffer uint blocking_leaves[], kept from frame to frame; includes common/bvh.glsl.
const uint LEAVES_PER_TILE = 4u;
const uint NO_LEAF = ~0u;

// Trying them takes as long as the walks of a few rays; where fewer than two per leaf end at them, the leaves are forgotten,
// and none are remembered for fewer that are blocked. docs/classification.md has what other numbers gave.
const uint RAYS_WORTH_A_LEAF = 2u;

// A subgroup tries and replaces those of its own share of the tile's pixels, eight to a leaf: bits of `slots`. All of them
// where it has the tile to itself, none where it has fewer pixels.
uint leaf_slots(uint first_pixel, uint pixels) { return (1u << (pixels >> 3)) - 1u << (first_pixel >> 3); }

uint known_leaf(uint tile, uint slots, uint slot) {
    return (slots >> slot & 1u) != 0u ? blocking_leaves[tile * LEAVES_PER_TILE + slot] : 0u;
}

bool leaves_known(uint tile, uint slots) {
    uint any_leaf = 0u;
    for (uint slot = 0u; slot < LEAVES_PER_TILE; ++slot) any_leaf |= known_leaf(tile, slots, slot);
    return any_leaf != 0u;
}

// Whether one of them blocks the ray. `start`: the slot to begin with, since neighbours find theirs in the same place.
// `useful` gets the bit of the one that did, `t_hit` where.
bool blocked_by_known(uint tile, uint slots, uint start, BvhRay ray, inout float t_hit, inout uint useful) {
    const uint leaf_count = uint(textureSize(scene_leaves)) / 3u;  // who knows from which tree a leaf comes
    bool blocked = false;
    for (uint i = 0u; i < LEAVES_PER_TILE; ++i) {
        const uint slot = start ^ i, leaf = known_leaf(tile, slots, slot) - 1u;
        if (!blocked && leaf < leaf_count) {
            uint unsure;  // left to the walk, which meets the leaf again
            if (bvh_hits_leaf(ray, leaf, t_hit, unsure)) blocked = true;
            if (blocked) useful |= 1u << slot;
        }
    }
    return blocked;
}

// For the next frame: leaves that ended a ray stay, and two that walks found take the places of others. `newest`: the last
// one that this lane's walks found, or NO_LEAF. Called by every lane of the subgroup, with the same numbers but for that.
void remember_leaves(uint tile, uint slots, bool known, uint useful, uint ended_early, uint ended_by_walk, uint newest) {
    const uint worth_it = RAYS_WORTH_A_LEAF * uint(bitCount(slots));
    if (!known && ended_by_walk < worth_it) return;
    if (ended_early < worth_it) useful = 0u;
    uvec2 found = uvec2(0u);
    if (ended_by_walk != 0u && max(ended_early, ended_by_walk) >= worth_it) {
        found.x = subgroupMax(newest + 1u);  // NO_LEAF + 1 is 0
        const uint least = subgroupMin(newest) + 1u;
        found.y = least != found.x ? least : 0u;
    }
    if (!subgroupElect()) return;
    for (uint slot = 0u; slot < LEAVES_PER_TILE; ++slot)
        if ((slots & ~useful & 1u << slot) != 0u) {
            blocking_leaves[tile * LEAVES_PER_TILE + slot] = found.x;
            found = uvec2(found.y, 0u);
        }
}
