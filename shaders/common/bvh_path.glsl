// SPDX-License-Identifier: MIT
// Where a walk through the hierarchy of host/bvh/bvh.h is: what is pending, and the step on from it. The question that is asked
// of nodes and leaves is the includer's (common/bvh.glsl: a ray's; classification/beam_query.glsl; visibility/light_walk.glsl), which writes the loop
//
//     while (true) {
//         if (bvh_at_leaf(path)) { .. bvh_take_leaf(path) .. }
//         BvhVisit visit = bvh_visit(path);
//         if (visit.wanted) { bvh_fetch(path, visit); visit.hits = .. }
//         bvh_go_on(path, visit);
//         if (.. || bvh_ended(path)) break;
//     }
//
// flat, without inner loops: every step tests one node and one leaf of what is pending, because lanes of a subgroup that sit
// in different loops wait for each other. A node's hit children stay one word (first child and a mask), so that a step
// pushes at most one. The stack is no array: words move through registers, a push shifts all of them. To index an array
// lane by lane a CPU device takes the lanes one by one, with a branch each that nothing can foresee, and that was a
// seventh of a ray's time. A GPU has few registers, and cannot index them lane by lane either: such an array lies in scratch memory.
// Shared memory each lane can index for itself, so with SHARED_STACK words wait there on a GPU, 64 bytes a lane.
//
// Includer declares: what common/scene_words.glsl needs; SHARED_STACK, where a workgroup may spare that.
#include "common/scene_words.glsl"

// A group of child nodes: first << 6 | order << 4 | mask. Order 3: the mask is reversed, the last child goes first.
struct BvhPath {
    uint group;
    uint leaf_first, leaf_mask;
    uint away;                      // bit k: the direction rises along axis k
    // Pending groups, max_bvh_depth - 2 at most (host/bvh/bvh.h). Only one of these two is in use:
    uvec4 top, second, third, last;  // they themselves, top.x the latest
    uint waiting;                    // how many of them wait in shared memory, with SHARED_STACK on a GPU
};

#ifdef SHARED_STACK
shared uint bvh_stack[ON_CPU ? 1u : 16u * GROUP_X * GROUP_Y];
uint bvh_stack_word(uint i) { return i * GROUP_X * GROUP_Y + gl_LocalInvocationIndex; }
#endif

BvhPath bvh_path(vec3 direction) {
    const uint away = uint(direction.x > 0.0) | uint(direction.y > 0.0) << 1 | uint(direction.z > 0.0) << 2;
    return BvhPath(1u, 0u, 0u, away, uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u), 0u);
}

bool bvh_ended(BvhPath path) { return ((path.group & 15u) | path.leaf_mask) == 0u; }

uint bvh_lowest_bit(uint mask) { return mask & (~mask + 1u); }

// Of a word with one of the four lowest bits set.
uint bvh_bit_index(uint bit) { return (bit >> 1) - (bit >> 3); }

uint bvh_reverse4(uint mask) {
    return ((mask < 8u ? 0xE6A2C480u : 0xF7B3D591u) >> ((mask & 7u) * 4u)) & 15u;
}

bool bvh_at_leaf(BvhPath path) { return path.leaf_mask != 0u; }

uint bvh_take_leaf(inout BvhPath path) {
    const uint bit = bvh_lowest_bit(path.leaf_mask);
    path.leaf_mask ^= bit;
    return path.leaf_first + bvh_bit_index(bit);
}

struct BvhVisit {
    bool wanted;
    uint bit, hits;  // of the group's mask: the node; of the node's children: those that the question concerns
    uvec4 n0, n1, n2;
};

// A new node may bring new leaves, so it waits until this step's leaf was the last at hand.
BvhVisit bvh_visit(BvhPath path) {
    BvhVisit visit;
    visit.wanted = path.leaf_mask == 0u && (path.group & 15u) != 0u;
    visit.bit = visit.hits = 0u;
    return visit;
}

void bvh_fetch(BvhPath path, inout BvhVisit visit) {
    visit.bit = bvh_lowest_bit(path.group);
    const uint number = (path.group >> 6) + (bvh_bit_index(visit.bit) ^ (path.group >> 4 & 3u));
    const int texel = int((number << 1) + number);  // three texels each; a product takes longer, and all waits for it
    visit.n0 = scene_node_texel(texel);
    visit.n1 = scene_node_texel(texel + 1);
    visit.n2 = scene_node_texel(texel + 2);
}

void bvh_push(inout BvhPath path, bool wanted, uint group) {
#ifdef SHARED_STACK
    if (!ON_CPU) {
        if (wanted) bvh_stack[bvh_stack_word(path.waiting++)] = group;
        return;
    }
#endif
    const bvec4 all = bvec4(wanted);
    path.last = mix(path.last, uvec4(path.third.w, path.last.xyz), all);
    path.third = mix(path.third, uvec4(path.second.w, path.third.xyz), all);
    path.second = mix(path.second, uvec4(path.top.w, path.second.xyz), all);
    path.top = mix(path.top, uvec4(group, path.top.xyz), all);
}

// Takes the latest pending group, if there is one.
void bvh_pop(inout BvhPath path, bool wanted) {
#ifdef SHARED_STACK
    if (!ON_CPU) {
        if (wanted && path.waiting != 0u) path.group = bvh_stack[bvh_stack_word(--path.waiting)];
        return;
    }
#endif
    if (path.top.x == 0u) wanted = false;
    const bvec4 all = bvec4(wanted);
    if (wanted) path.group = path.top.x;
    path.top = mix(path.top, uvec4(path.top.yzw, path.second.x), all);
    path.second = mix(path.second, uvec4(path.second.yzw, path.third.x), all);
    path.third = mix(path.third, uvec4(path.third.yzw, path.last.x), all);
    path.last = mix(path.last, uvec4(path.last.yzw, 0u), all);
}

// To the children that `visit` found, or to what is pending.
void bvh_go_on(inout BvhPath path, BvhVisit visit) {
    path.group ^= visit.bit;
    const uint rest = path.group;
    bool push = false;
    if (visit.wanted) {
        path.leaf_mask = visit.hits & visit.n0.w >> 28;
        path.leaf_first = visit.n1.y;
        const uint nodes = visit.hits & visit.n0.w >> 24;
        if (nodes != 0u) {
            push = (rest & 15u) != 0u;
            // The child nearest to the light first: casters are more often found there than near the receiver.
            const bool last_first = (path.away >> (visit.n1.x & 3u) & 1u) != 0u;
            path.group = visit.n1.x >> 2 << 6 | (last_first ? 48u | bvh_reverse4(nodes) : nodes);
        }
    }
    bvh_push(path, push, rest);
    bvh_pop(path, (path.group & 15u) == 0u);
}
