// SPDX-License-Identifier: MIT
// One walk through the hierarchy of host/bvh/bvh.h for all lanes of a subgroup, as common/bvh_path.glsl's is one lane's: for software
// devices, whose lanes are a vector of one thread. Pixels beside each other ask for much the same nodes; one that any of them asks for is
// loaded once, a texel by each lane, and what is pending lies in lanes, so that a push is a choice and a pop a shuffle. Of children that face
// lanes differently the order is the first lane's.
//
// Includer has the extension GL_KHR_shader_subgroup_shuffle, common/bvh_leaf.glsl and common/bvh_path.glsl, and is compiled by class. All
// lanes take part.

// Not on a driver that executes both sides of every branch, as Mesa 22's does, which fetches texels. Four words of each of four lanes hold the
// groups that may be pending, and or_of_lanes() knows 16 lanes.
const bool LANES_WALK_TOGETHER = HAS_SCENE_LOADED_NODES && LANES_IN_STEP >= 4u && LANES_IN_STEP <= 16u &&
                                 LANES_IN_STEP <= gl_WorkGroupSize.x * gl_WorkGroupSize.y;

struct BvhSharedPath {
    uint group;  // as BvhPath's
    uint leaf_first, leaf_mask;
    uint away;
    uint waiting;   // groups; the i-th in lane i % LANES_IN_STEP of a word
    uvec4 pending;
};

BvhSharedPath bvh_shared_path(vec3 direction) {
    const BvhPath path = bvh_path(direction);
    return BvhSharedPath(path.group, 0u, 0u, subgroupShuffle(path.away, 0u), 0u, uvec4(0u));
}

uint or_of_lanes(uint own) {
    [[unroll]] for (uint apart = 1u; apart < 16u; apart <<= 1)
        if (apart < LANES_IN_STEP) own |= subgroupShuffleXor(own, apart);
    return own;
}
bool any_of_lanes(bool own) { return or_of_lanes(own ? 1u : 0u) != 0u; }

bool bvh_at_leaf(BvhSharedPath path) { return path.leaf_mask != 0u; }
bool bvh_ended(BvhSharedPath path) { return ((path.group & 15u) | path.leaf_mask) == 0u; }

// Three texels from the first one of a node or a leaf.
struct BvhTexels {
    uvec4 n0, n1, n2;
};

int texel_of_lane(uint number) { return int((number << 1) + number + min(gl_SubgroupInvocationID, 2u)); }
uvec4 of_lane(uvec4 own, uint lane) {
    return uvec4(subgroupShuffle(own.x, lane), subgroupShuffle(own.y, lane), subgroupShuffle(own.z, lane), subgroupShuffle(own.w, lane));
}
BvhTexels from_lanes(uvec4 own) { return BvhTexels(of_lane(own, 0u), of_lane(own, 1u), of_lane(own, 2u)); }

// `bit`: which of those at hand.
BvhLeaf bvh_take_leaf(inout BvhSharedPath path, out uint bit, out uint leaf) {
    bit = bvh_lowest_bit(path.leaf_mask);
    path.leaf_mask ^= bit;
    leaf = path.leaf_first + bvh_bit_index(bit);
    const BvhTexels t = from_lanes(scene_leaf_texel(texel_of_lane(leaf)));
    return bvh_leaf_of(uintBitsToFloat(t.n0), uintBitsToFloat(t.n1), uintBitsToFloat(t.n2));
}

BvhTexels bvh_take_node(inout BvhSharedPath path, out uint bit) {
    bit = bvh_lowest_bit(path.group);
    path.group ^= bit;
    return from_lanes(scene_node_texel(texel_of_lane((path.group >> 6) + (bvh_bit_index(bit) ^ (path.group >> 4 & 3u)))));
}

// What a step from a node was.
struct BvhStep {
    uint rest;            // of the group that was left
    uint leaves, nodes;   // of the node's children
    bool down, push, pop, last_first;
    uint at;              // pushed or popped
};

// To the children that any lane has found, or to what is pending. Choices, since all that follows waits for a branch.
BvhStep bvh_go_on(inout BvhSharedPath path, BvhTexels node, uint own_hits) {
    const uint hits = or_of_lanes(own_hits), leaves = node.n0.w >> 28, nodes = hits & node.n0.w >> 24 & 15u, left = path.group & 15u;
    path.leaf_first = node.n1.y;
    path.leaf_mask = hits & leaves;
    const bool down = nodes != 0u, push = down && left != 0u, pop = !down && left == 0u && path.waiting != 0u;
    const uint at = pop ? path.waiting - 1u : path.waiting;
    uint latest = 0u;
    [[unroll]] for (uint i = 0u; i < 4u; ++i)
        if (i * LANES_IN_STEP < 16u) {
            const uint word = subgroupShuffle(path.pending[i], at % LANES_IN_STEP);
            if (at / LANES_IN_STEP == i) latest = word;
            if (push && i * LANES_IN_STEP + gl_SubgroupInvocationID == at) path.pending[i] = path.group;
        }
    path.waiting = push ? at + 1u : at;
    const bool last_first = (path.away >> (node.n1.x & 3u) & 1u) != 0u;
    path.group = down ? node.n1.x >> 2 << 6 | (last_first ? 48u | bvh_reverse4(nodes) : nodes) : pop ? latest : path.group;
    return BvhStep(left, leaves, nodes, down, push, pop, last_first, at);
}

// What a lane would have come to by itself, for whom the answer to what it did not ask for would be another one: of the path's masks those
// that are its own.
struct BvhOwn {
    uint group, leaves;
    uvec2 pending;  // four bits of each
};

BvhOwn bvh_own(bool own) { return BvhOwn(own ? 1u : 0u, 0u, uvec2(0u)); }

bool bvh_has_own(BvhSharedPath path, BvhOwn own) {
    return (own.group & path.group & 15u | own.leaves & path.leaf_mask | own.pending.x | own.pending.y) != 0u;
}

void bvh_go_on(inout BvhOwn own, BvhStep to, uint own_hits) {
    const uint shift = (to.at & 7u) << 2, word = to.at > 7u ? own.pending.y : own.pending.x, latest = word >> shift & 15u,
               now = word & ~(15u << shift) | (to.push ? own.group & to.rest : 0u) << shift;
    if (to.at > 7u)
        own.pending.y = now;
    else
        own.pending.x = now;
    const uint nodes = own_hits & to.nodes;
    own.group = to.down ? (to.last_first ? bvh_reverse4(nodes) : nodes) : to.pop ? latest : own.group;
    own.leaves = own_hits & to.leaves;
}
