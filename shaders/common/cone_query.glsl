// SPDX-License-Identifier: MIT
// One question to the hierarchy of host/bvh/bvh.h: does a cone of shadow rays meet nothing, is it blocked by a surface that
// closes it off (common/closing_patch.glsl), or neither? The first two are proofs that no ray of the cone is needed.
// A cone that has met something is followed along its axis only: what remains to be found is a cover.
//
// Includer declares: uniform usamplerBuffer scene_nodes, scene_leaves, neighbours; const uint PATCH (triangles), BUDGET (steps).
#include "common/bvh.glsl"
#include "common/cone.glsl"
#include "common/cone_slabs.glsl"

const uint CONE_MIXED = 0u;
const uint CONE_CLEAR = 1u;
const uint CONE_COVERED = 2u;

struct Walk {
    Cone cone;
    ConeSlabs wide, thin;  // of the cone and of its axis
    bool clean;            // nothing has been met
    bool covered;
};
#include "common/bvh_walk.glsl"
#include "common/closing_patch.glsl"

// All rays start at the apex, so they come from its side. The three corners and the apex must not be in one plane.
int cover_side(Walk walk, vec3 a, vec3 b, vec3 c) {
    const vec2 side = facing(a, b, c);
    return certainly_positive(side) ? 1 : certainly_negative(side) ? -1 : 0;
}

uint walk_children(Walk walk, uvec4 n0, uvec4 n1, uvec4 n2) {
    ConeSlabs slabs = walk.thin;
    if (walk.clean) slabs = walk.wide;
    return cone_hit_children(slabs, walk.cone.apex, n0, n1, n2);
}

// Most leaves whose boxes a cone meets lie beside it: this much can be seen before any edge is looked at.
bool beside(Leaf v, float spread) {
    const vec3 lo = min(min(v.v0, v.v1), min(v.v2, v.v3)), hi = max(max(v.v0, v.v1), max(v.v2, v.v3));
    const float reach = spread * hi.z + CONE_ROUNDING * (taxicab(max(abs(lo), abs(hi))) * 2.0);
    return max(lo.x, lo.y) > reach || min(hi.x, hi.y) < -reach || hi.z < -reach;
}

bool walk_leaf(inout Walk walk, uint leaf) {
    const Leaf v = cone_leaf(walk.cone, leaf);
    if (beside(v, walk.clean ? walk.cone.spread : 0.0)) return false;
    const vec2 s01 = axis_side(v.v0, v.v1), s12 = axis_side(v.v1, v.v2), s20 = axis_side(v.v2, v.v0),
               s13 = axis_side(v.v1, v.v3), s32 = axis_side(v.v3, v.v2), s21 = vec2(-s12.x, s12.y);
    const uint first = axis_pierces(s12, s20, s01, v.v0, v.v1, v.v2), second = axis_pierces(s13, s32, s21, v.v2, v.v1, v.v3);
    if (walk.clean)
        walk.clean = first == PIERCES_NOT && second == PIERCES_NOT && !edge_meets_cone(walk.cone, v.v0, v.v1) &&
                     !edge_meets_cone(walk.cone, v.v1, v.v2) && !edge_meets_cone(walk.cone, v.v2, v.v0) &&
                     !edge_meets_cone(walk.cone, v.v1, v.v3) && !edge_meets_cone(walk.cone, v.v3, v.v2);
    // One attempt for both triangles: they share an edge, so that a patch from one goes on into the other where it must, and
    // lanes whose axes pass different halves of a leaf prove together.
    const bool pierced = first == PIERCES || second == PIERCES;
    if (pierced && covers(walk, leaf << 1 | uint(first != PIERCES))) walk.covered = true;
    return walk.covered;
}

Walk cone_walk(Cone cone) {
    return Walk(cone, cone_slabs(cone.frame[2], cone.spread, 0.0), cone_slabs(cone.frame[2], 0.0, 0.0), true, false);
}

// CONE_CLEAR, CONE_COVERED or CONE_MIXED.
uint query_cone(Cone cone) {
    Walk walk = cone_walk(cone);
    const bool finished = walk_tree(walk, cone.frame[2], BUDGET);
    return walk.covered ? CONE_COVERED : walk.clean && finished ? CONE_CLEAR : CONE_MIXED;
}
