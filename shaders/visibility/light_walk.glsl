// SPDX-License-Identifier: MIT
// The walk of one pixel through the tree, with the cone to its light: what triangles hide of the light is united. On a GPU each lane walks by
// itself, towards leaves until all of a subgroup have one, since looking at a leaf is the dearest step. On some CPUs they walk together.
//
// Includer has common/bvh.glsl, common/cone_slabs.glsl, light_mask.glsl, leaf_cover.glsl and seen_light.glsl; slabs_to(), where a light's are;
// WALK_BUDGET, where a walk may be given up: nodes and leaves that it may look at.

ConeSlabs slabs_to(SeenLight seen);

// The receiver's own plane hides what is below it, which a start above the surface would let pass at the surface's end.
LightMask below_horizon(SeenLight seen, vec3 normal) {
    return mask_flipped(positive_side(light_line(seen.shape, seen.receiver.dither, lit_side(seen, normal))), true);
}

struct Walk {
    bool ended;  // nothing is left to look at; false: given up, left undone where a driver ends loops (below), or not `own`
    uint steps;
};

#if CLASS_CPU
#include "visibility/bvh_together.glsl"

// A turn costs the less, and what a lane waits for is what its neighbours look at.
Walk walk_together(SeenLight seen, bool own, inout LightMask hidden) {
    bool live = own && !mask_is_full(hidden);
    BvhSharedPath path = bvh_shared_path(seen.span[2]);
    BvhOwn asked = bvh_own(live);
    const ConeSlabs slabs = slabs_to(seen);
    uint steps = 0u;
    bool given_up = false;
    bool ended = !any_of_lanes(live);
    while (!ended) {
        uint bit;
        if (bvh_at_leaf(path)) {
            uint leaf;
            const BvhLeaf corners = bvh_take_leaf(path, bit, leaf);
            const bool asks = live && (asked.leaves & bit) != 0u;
            hide_by_leaf(seen.receiver, seen.shape, leaf, corners, asks, hidden);
            if (asks) ++steps;
            if (mask_is_full(hidden)) live = false;
#ifdef WALK_BUDGET
            if (asks && live && steps >= WALK_BUDGET) {
                live = false;
                given_up = bvh_has_own(path, asked);
            }
#endif
        } else {
            const BvhTexels node = bvh_take_node(path, bit);
            const bool asks = live && (asked.group & bit) != 0u;
            const uint all_hits = cone_hit_children(slabs, seen.receiver.start, node.n0, node.n1, node.n2), hits = asks ? all_hits : 0u;
            bvh_go_on(asked, bvh_go_on(path, node, hits), hits);
            if (asks) ++steps;
        }
        ended = bvh_ended(path) || !any_of_lanes(live);
    }
    return Walk(own && !given_up && (mask_is_full(hidden) || !bvh_has_own(path, asked)), steps);
}
#endif

Walk walk_to_light(SeenLight seen, bool own, inout LightMask hidden) {
#if CLASS_CPU
    if (LANES_WALK_TOGETHER) return walk_together(seen, own, hidden);
#endif
    BvhPath path = bvh_path(seen.span[2]);
    uint steps = 0u;
    bool ended = !own || mask_is_full(hidden);
    while (!ended) {
        while (!ended && !bvh_at_leaf(path)) {
            BvhVisit visit = bvh_visit(path);
            bvh_fetch(path, visit);
            visit.hits = cone_hit_children(slabs_to(seen), seen.receiver.start, visit.n0, visit.n1, visit.n2);
            bvh_go_on(path, visit);
            ++steps;
            if (bvh_ended(path)) ended = true;
        }
        uint leaf = 0u;
        const bool at_leaf = !ended;
        if (at_leaf) leaf = bvh_take_leaf(path);
        hide_by_leaf(seen.receiver, seen.shape, leaf, bvh_leaf(leaf), at_leaf, hidden);
        ++steps;
        if (mask_is_full(hidden) || bvh_ended(path)) ended = true;
#ifdef WALK_BUDGET
        if (steps >= WALK_BUDGET) ended = true;
#endif
    }
    // Mesa 22's lavapipe ends all loops of a workgroup after 65 535 turns, whatever they wait for: so of the walk itself, not of the variable
    // that the loop ran on, of which every compiler knows that a loop until `ended` has ended.
    return Walk(own && (mask_is_full(hidden) || bvh_ended(path)), steps);
}

// With those of the open samples hidden that a ray finds hidden, of a length of `t_max` ways to the sample.
LightMask with_samples_by_ray(SeenLight seen, float t_max, bool wanted, LightMask hidden) {
    LightMask asked_by_ray = NO_SAMPLES;
    bool asking = wanted && !mask_is_full(hidden);
    while (asking) {
        const LightMask open = mask_lowest(mask_without(mask_flipped(hidden, true), asked_by_ray));
        const vec3 way = way_to_sample(seen, sample_point(seen.shape, mask_index(open)));
        float unread = 0.0;
        if (occluded_from(seen.receiver.start, seen.receiver.beyond_edge_m, way, 0.0, t_max, unread)) hidden = mask_or(hidden, open);
        asked_by_ray = mask_or(asked_by_ray, open);
        if (mask_is_full(mask_or(hidden, asked_by_ray))) asking = false;
    }
    return hidden;
}

// Rounded lines through a corner need not meet in a point, and a closed surface could leave a sample there: where no more are left than the
// corners that closed surfaces have make, they are rays.
const uint LAST_SAMPLES = LIGHT_SAMPLES / 64u + 2u;

bool last_samples(LightMask hidden) { return mask_count(hidden) + LAST_SAMPLES >= LIGHT_SAMPLES; }
