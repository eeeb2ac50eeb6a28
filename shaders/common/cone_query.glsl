// SPDX-License-Identifier: MIT
// One question to the hierarchy of host/bvh.h: does a cone of shadow rays meet nothing, is it blocked by a surface that
// closes it off (common/cover.glsl), or neither? The first two are proofs that no ray of the cone is needed.
// Two walks: the first ends at whatever the cone meets; where there was something, the second follows the axis alone and
// tries what it pierces.
//
// Includer declares: uniform usamplerBuffer scene_nodes, scene_leaves, neighbours; const uint PATCH (triangles), BUDGET (steps).
#include "common/bvh.glsl"
#include "common/cone.glsl"
#include "common/cone_slabs.glsl"

struct Walk {
    Cone cone;
    ConeSlabs slabs;  // of the stage
};
#include "common/bvh_walk.glsl"
#include "common/cover.glsl"

// All rays start at the apex, so they come from its side. The three corners and the apex must not be in one plane.
int cover_side(Walk walk, vec3 a, vec3 b, vec3 c) {
    const vec2 side = facing(a, b, c);
    return certainly_positive(side) ? 1 : certainly_negative(side) ? -1 : 0;
}

const uint STAGE_CLEAR = 0u;  // does the cone meet anything?
const uint STAGE_COVER = 1u;  // does its axis pierce what covers it?

uint walk_children(Walk walk, uint stage, uvec4 n0, uvec4 n1, uvec4 n2) {
    return cone_hit_children(walk.slabs, walk.cone.apex, n0, n1, n2);
}

uint walk_leaf(Walk walk, uint stage, uint leaf) {
    const Leaf v = cone_leaf(walk.cone, leaf);
    const vec2 s01 = axis_side(v.v0, v.v1), s12 = axis_side(v.v1, v.v2), s20 = axis_side(v.v2, v.v0),
               s13 = axis_side(v.v1, v.v3), s32 = axis_side(v.v3, v.v2), s21 = vec2(-s12.x, s12.y);
    const uint first = axis_pierces(s12, s20, s01, v.v0, v.v1, v.v2), second = axis_pierces(s13, s32, s21, v.v2, v.v1, v.v3);
    if (stage == STAGE_CLEAR) {
        const bool meets = first != PIERCES_NOT || second != PIERCES_NOT || edge_meets_cone(walk.cone, v.v0, v.v1) ||
                           edge_meets_cone(walk.cone, v.v1, v.v2) || edge_meets_cone(walk.cone, v.v2, v.v0) ||
                           edge_meets_cone(walk.cone, v.v1, v.v3) || edge_meets_cone(walk.cone, v.v3, v.v2);
        return meets ? LEAF_ENDS_WALK : LEAF_IS_NOTHING;
    }
    // Of a folded pair one triangle is tried: the other is as near to the fold.
    return first == PIERCES ? leaf << 1 : second == PIERCES ? leaf << 1 | 1u : LEAF_IS_NOTHING;
}

bool walk_examine(Walk walk, uint stage, uint word) { return stage == STAGE_COVER && covers(walk, word); }

// CONE_CLEAR, CONE_COVERED or CONE_MIXED.
uint query_cone(Cone cone) {
    const vec3 axis = cone.frame[2];
    const uint clear = walk_tree(Walk(cone, cone_slabs(axis, cone.spread, 0.0)), STAGE_CLEAR, axis, BUDGET);
    uint cover = WALK_CUT;
    if (clear != WALK_COMPLETE) cover = walk_tree(Walk(cone, cone_slabs(axis, 0.0, 0.0)), STAGE_COVER, axis, BUDGET);
    return clear == WALK_COMPLETE ? CONE_CLEAR : cover == WALK_ENDED ? CONE_COVERED : CONE_MIXED;
}
