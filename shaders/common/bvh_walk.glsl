// SPDX-License-Identifier: MIT
// The walk through the hierarchy for other questions than a ray's: what passes a node and what a leaf means is the
// includer's. The loop is that of occluded() in common/bvh.glsl, where its shape is explained.
//
// Includer has common/bvh.glsl and defines: struct Walk, the question; and the functions below for each `stage` of it that it
// walks the tree for, a constant.

// Children of a node that matter, bit k for child k.
uint walk_children(Walk walk, uint stage, uvec4 n0, uvec4 n1, uvec4 n2);
// Looks at a leaf: LEAF_IS_NOTHING, LEAF_ENDS_WALK, or a word to examine.
uint walk_leaf(Walk walk, uint stage, uint leaf);
// Examines it; true ends the walk. What takes long belongs here: lanes wait for each other and examine together.
bool walk_examine(Walk walk, uint stage, uint word);

const uint LEAF_IS_NOTHING = ~0u;
const uint LEAF_ENDS_WALK = ~1u;

const uint WALK_ENDED = 0u;     // by a leaf or what was examined
const uint WALK_COMPLETE = 1u;  // no leaf ended it
const uint WALK_CUT = 2u;       // `budget` steps were not enough

// Children far along `direction` come first.
uint walk_tree(Walk walk, uint stage, vec3 direction, uint budget) {
    const uint away = uint(direction.x > 0.0) | uint(direction.y > 0.0) << 1 | uint(direction.z > 0.0) << 2;
    uint group = 1u;
    uint leaf_first = 0u, leaf_mask = 0u;
    uint stack[bvh_stack_size];
    uint depth = 0u;
    bool done = false;
    uint examined = LEAF_IS_NOTHING;
    uint steps = 0u;
    while (true) {
        const bool waits = examined != LEAF_IS_NOTHING;
        const uint leaf_bit = waits ? 0u : leaf_mask & (~leaf_mask + 1u);
        if (leaf_bit != 0u) {
            const uint found = walk_leaf(walk, stage, leaf_first + bvh_bit_index(leaf_bit));
            if (found == LEAF_ENDS_WALK) done = true;
            if (found < LEAF_ENDS_WALK) examined = found;
            leaf_mask ^= leaf_bit;
        }
        const bool visit = !waits && leaf_mask == 0u && (group & 15u) != 0u;
        uint hits = 0u, bit = 0u;
        uvec4 n0, n1, n2;
        if (visit) {
            bit = group & (~group + 1u);
            const int texel = int(((group >> 6) + (bvh_bit_index(bit) ^ (group >> 4 & 3u))) * 3u);
            n0 = texelFetch(scene_nodes, texel);
            n1 = texelFetch(scene_nodes, texel + 1);
            n2 = texelFetch(scene_nodes, texel + 2);
            hits = walk_children(walk, stage, n0, n1, n2);
        }
        group ^= bit;
        stack[depth] = group;
        if (visit) {
            leaf_mask = hits & n0.w >> 28;
            leaf_first = n1.y;
            hits &= n0.w >> 24;
            if (hits != 0u) {
                depth += uint((group & 15u) != 0u);
                const bool last_first = (away >> (n1.x & 3u) & 1u) != 0u;
                group = n1.x >> 2 << 6 | (last_first ? 48u | bvh_reverse4(hits) : hits);
            }
        }
        if ((group & 15u) == 0u && depth > 0u) group = stack[--depth];
        if (subgroupOr(examined == LEAF_IS_NOTHING && !done ? 1u : 0u) == 0u && examined != LEAF_IS_NOTHING) {
            if (walk_examine(walk, stage, examined)) done = true;
            examined = LEAF_IS_NOTHING;
        }
        steps += waits ? 0u : 1u;
        if (examined != LEAF_IS_NOTHING) continue;
        if (done || steps >= budget || ((group & 15u) | leaf_mask) == 0u) break;
    }
    return done ? WALK_ENDED : ((group & 15u) | leaf_mask) == 0u ? WALK_COMPLETE : WALK_CUT;
}
