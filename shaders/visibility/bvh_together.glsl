// SPDX-License-Identifier: MIT
// One walk through the hierarchy of host/bvh/bvh.h for all lanes of a subgroup, as common/bvh_path.glsl's is one lane's: for software
// devices, whose lanes are a vector of one thread. Pixels beside each other ask for much the same nodes; one that any of them asks for is
// loaded once, a texel by each lane, and what is pending lies in lanes, so that a push is a choice and a pop a shuffle. Every lane knows
// what it would have come to by itself, and asks no more, so that who walks together shows in nothing but the order: of children that
// face lanes differently, the first lane's.
//
// Includer has the extension GL_KHR_shader_subgroup_shuffle, common/bvh_leaf.glsl and common/bvh_path.glsl, and is compiled by class. All
// lanes take part, LANES_IN_STEP of them, which are four or more.

struct BvhSharedPath {
    uint group, own_group;  // as BvhPath's; of its mask, the nodes that the lane itself asks for
    uint leaf_first, leaf_mask, own_leaves;
    uint away;
    uint waiting;           // groups; the i-th in lane i % LANES_IN_STEP of a word, four bits of own_pending each
    uvec4 pending;
    uvec2 own_pending;
};

BvhSharedPath bvh_shared_path(vec3 direction, bool own) {
    const BvhPath path = bvh_path(direction);
    return BvhSharedPath(path.group, own ? path.group : 0u, 0u, 0u, 0u, subgroupShuffle(path.away, 0u), 0u, uvec4(0u), uvec2(0u));
}

uint or_of_lanes(uint own) {
    [[unroll]] for (uint apart = 1u; apart < 16u; apart <<= 1)
        if (apart < LANES_IN_STEP) own |= subgroupShuffleXor(own, apart);
    return own;
}

bool bvh_at_leaf(BvhSharedPath path) { return path.leaf_mask != 0u; }
bool bvh_ended(BvhSharedPath path) { return ((path.group & 15u) | path.leaf_mask) == 0u; }

// Whether the lane by itself would have more to look at.
bool bvh_has_own(BvhSharedPath path) {
    return (path.own_group & path.group & 15u | path.own_leaves & path.leaf_mask | path.own_pending.x | path.own_pending.y) != 0u;
}

// Three texels from the first one of a node or a leaf.
struct BvhTexels {
    uvec4 n0, n1, n2;
};

int texel_of_lane(uint number) { return int((number << 1) + number + min(gl_SubgroupInvocationID, 2u)); }
uvec4 of_lane(uvec4 own, uint lane) {
    return uvec4(subgroupShuffle(own.x, lane), subgroupShuffle(own.y, lane), subgroupShuffle(own.z, lane), subgroupShuffle(own.w, lane));
}
BvhTexels from_lanes(uvec4 own) { return BvhTexels(of_lane(own, 0u), of_lane(own, 1u), of_lane(own, 2u)); }

BvhLeaf bvh_take_leaf(inout BvhSharedPath path, out uint leaf, out bool own) {
    const uint bit = bvh_lowest_bit(path.leaf_mask);
    path.leaf_mask ^= bit;
    own = (path.own_leaves & bit) != 0u;
    leaf = path.leaf_first + bvh_bit_index(bit);
    const BvhTexels t = from_lanes(scene_leaf_texel(texel_of_lane(leaf)));
    return bvh_leaf_of(uintBitsToFloat(t.n0), uintBitsToFloat(t.n1), uintBitsToFloat(t.n2));
}

BvhTexels bvh_take_node(inout BvhSharedPath path, out bool own) {
    const uint bit = bvh_lowest_bit(path.group);
    path.group ^= bit;
    own = (path.own_group & bit) != 0u;
    return from_lanes(scene_node_texel(texel_of_lane((path.group >> 6) + (bvh_bit_index(bit) ^ (path.group >> 4 & 3u)))));
}

// To the children that any lane has found, or to what is pending. Choices, since all that follows waits for a branch.
void bvh_go_on(inout BvhSharedPath path, BvhTexels node, uint own_hits) {
    const uint hits = or_of_lanes(own_hits), leaves = node.n0.w >> 28, nodes = hits & node.n0.w >> 24 & 15u;
    path.leaf_first = node.n1.y;
    path.leaf_mask = hits & leaves;
    path.own_leaves = own_hits & leaves;
    const bool down = nodes != 0u, rest = (path.group & 15u) != 0u, push = down && rest, pop = !down && !rest && path.waiting != 0u;
    const uint at = pop ? path.waiting - 1u : path.waiting, shift = (at & 7u) << 2;
    uint latest = 0u;
    [[unroll]] for (uint i = 0u; i < 4u; ++i)
        if (i * LANES_IN_STEP < 16u) {
            const uint word = subgroupShuffle(path.pending[i], at % LANES_IN_STEP);
            if (at / LANES_IN_STEP == i) latest = word;
            if (push && i * LANES_IN_STEP + gl_SubgroupInvocationID == at) path.pending[i] = path.group;
        }
    const uint own_word = at > 7u ? path.own_pending.y : path.own_pending.x, own_latest = own_word >> shift & 15u,
               own_now = own_word & ~(15u << shift) | (push ? path.own_group & path.group & 15u : 0u) << shift;
    if (at > 7u)
        path.own_pending.y = own_now;
    else
        path.own_pending.x = own_now;
    path.waiting = push ? at + 1u : at;
    const bool last_first = (path.away >> (node.n1.x & 3u) & 1u) != 0u;
    const uint own_nodes = own_hits & nodes;
    path.own_group = down ? (last_first ? bvh_reverse4(own_nodes) : own_nodes) : pop ? own_latest : path.own_group;
    path.group = down ? node.n1.x >> 2 << 6 | (last_first ? 48u | bvh_reverse4(nodes) : nodes) : pop ? latest : path.group;
}
