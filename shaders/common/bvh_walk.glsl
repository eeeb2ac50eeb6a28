// SPDX-License-Identifier: MIT
// The walk through the hierarchy for other questions than a ray's: what passes a node and what a leaf means is the
// includer's. The loop is that of occluded() in common/bvh.glsl, where its shape is explained.
//
// Includer has common/bvh.glsl and defines: struct Walk, the question and what is known so far.

// Children of a node that matter, bit k for child k.
uint walk_children(Walk walk, uvec4 n0, uvec4 n1, uvec4 n2);
// Looks at a leaf; true ends the walk.
bool walk_leaf(inout Walk walk, uint leaf);

// Children far along `direction` come first. False where `budget` steps were not enough to see everything.
bool walk_tree(inout Walk walk, vec3 direction, uint budget) {
    const uint away = uint(direction.x > 0.0) | uint(direction.y > 0.0) << 1 | uint(direction.z > 0.0) << 2;
    uint group = 1u;
    uint leaf_first = 0u, leaf_mask = 0u;
    uint stack[bvh_stack_size];
    uint depth = 0u;
    bool done = false;
    uint steps = 0u;
    while (true) {
        const uint leaf_bit = leaf_mask & (~leaf_mask + 1u);
        if (leaf_bit != 0u) {
            if (walk_leaf(walk, leaf_first + bvh_bit_index(leaf_bit))) done = true;
            leaf_mask ^= leaf_bit;
        }
        const bool visit = leaf_mask == 0u && (group & 15u) != 0u;
        uint hits = 0u, bit = 0u;
        uvec4 n0, n1, n2;
        if (visit) {
            bit = group & (~group + 1u);
            const int texel = int(((group >> 6) + (bvh_bit_index(bit) ^ (group >> 4 & 3u))) * 3u);
            n0 = texelFetch(scene_nodes, texel);
            n1 = texelFetch(scene_nodes, texel + 1);
            n2 = texelFetch(scene_nodes, texel + 2);
            hits = walk_children(walk, n0, n1, n2);
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
        ++steps;
        if (done || steps >= budget || ((group & 15u) | leaf_mask) == 0u) break;
    }
    return done || ((group & 15u) | leaf_mask) == 0u;
}
