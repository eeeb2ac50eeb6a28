// SPDX-License-Identifier: MIT
// The question of common/cone_query.glsl for many pixels at once. The beam is a cone that is as wide as the pixels at its
// start and so contains the cones of all of them; whatever it does not meet, no ray of theirs meets.
// The surface that the pixels lie on would touch every beam. Two bounds of where rays start tell it from casters: a
// triangle whose plane has all starts on the side that the rays go to is behind them. The bounds are a disc across the sun
// and a box along the surface, which is flat where the pixels are.
// Nothing met: all lit. Closed off: all shadowed. Else the tile is left to its pixels.
//
// Includer declares: uniform usamplerBuffer scene_nodes, scene_leaves, neighbours; const uint PATCH (triangles), BUDGET
// (steps).
#include "common/bvh.glsl"
#include "common/cone.glsl"
#include "common/cone_slabs.glsl"

// A box that contains all starts, in the cone's frame: half its edges.
struct Starts {
    vec3 centre, u, v, w;
};

struct Walk {
    Cone cone;
    Starts starts;
    ConeSlabs slabs;  // of the stage
};
#include "common/bvh_walk.glsl"
#include "common/cover.glsl"

const int BEHIND = 2;

// From which side all rays of the beam come to a triangle ahead of all starts, 1 or -1 as cover_side(); BEHIND if they
// cannot meet it, since they start on the far side and lead away; else 0.
int beam_side(Walk walk, vec3 a, vec3 b, vec3 c) {
    const vec3 ab = b - a, ac = c - a;
    const vec3 n = cross(ab, ac);
    const vec3 from = walk.starts.centre - a;
    const float extent = abs(dot(n, walk.starts.u)) + abs(dot(n, walk.starts.v)) + abs(dot(n, walk.starts.w));
    const float size = taxicab(a) + taxicab(b) + taxicab(c);
    const float n_error = CONE_ROUNDING * size * (taxicab(ab) + taxicab(ac));
    const float along = n.z < 0.0 ? -dot(n, from) : dot(n, from);
    const float error = n_error * (taxicab(from) + walk.cone.radius) + CONE_ROUNDING * taxicab(n) * size;
    const bool crossed = abs(n.z) > walk.cone.spread * length(n.xy) * 1.001 + n_error;
    if (!crossed) return 0;
    if (along - extent > error) return BEHIND;
    return along + extent < -error ? (n.z < 0.0 ? -1 : 1) : 0;
}

int cover_side(Walk walk, vec3 a, vec3 b, vec3 c) {
    const int side = beam_side(walk, a, b, c);
    return side == BEHIND ? 0 : side;
}

const uint STAGE_CLEAR = 0u;  // does the beam meet anything?
const uint STAGE_COVER = 1u;  // does its axis pierce what covers it?

uint walk_children(Walk walk, uint stage, uvec4 n0, uvec4 n1, uvec4 n2) {
    return cone_hit_children(walk.slabs, walk.cone.apex, n0, n1, n2);
}

bool beam_meets(Walk walk, vec3 a, vec3 b, vec3 c) {
    if (max(max(a.z, b.z), c.z) < -CONE_ROUNDING * (taxicab(a) + taxicab(b) + taxicab(c))) return false;
    if (beam_side(walk, a, b, c) == BEHIND) return false;
    return axis_passes(axis_side(b, c), axis_side(c, a), axis_side(a, b), a, b, c) != PIERCES_NOT ||
           edge_meets_cone(walk.cone, a, b) || edge_meets_cone(walk.cone, b, c) || edge_meets_cone(walk.cone, c, a);
}

// Whether the axis passes through a triangle for certain, ahead of all starts.
bool beam_pierces(Walk walk, vec3 a, vec3 b, vec3 c) {
    return axis_passes(axis_side(b, c), axis_side(c, a), axis_side(a, b), a, b, c) == PIERCES &&
           cover_side(walk, a, b, c) != 0;
}

uint walk_leaf(Walk walk, uint stage, uint leaf) {
    const Leaf v = cone_leaf(walk.cone, leaf);
    if (stage == STAGE_CLEAR)
        return beam_meets(walk, v.v0, v.v1, v.v2) || (v.v3 != v.v2 && beam_meets(walk, v.v2, v.v1, v.v3)) ? LEAF_ENDS_WALK
                                                                                                        : LEAF_IS_NOTHING;
    return beam_pierces(walk, v.v0, v.v1, v.v2)   ? leaf << 1
           : beam_pierces(walk, v.v2, v.v1, v.v3) ? leaf << 1 | 1u
                                                  : LEAF_IS_NOTHING;
}

bool walk_examine(Walk walk, uint stage, uint word) { return stage == STAGE_COVER && covers(walk, word); }

// CONE_CLEAR, CONE_COVERED or CONE_MIXED.
uint query_beam(Cone cone, Starts starts) {
    const vec3 axis = cone.frame[2];
    const uint clear =
        walk_tree(Walk(cone, starts, cone_slabs(axis, cone.spread, cone.radius)), STAGE_CLEAR, axis, BUDGET);
    uint cover = WALK_CUT;
    if (clear == WALK_ENDED) cover = walk_tree(Walk(cone, starts, cone_slabs(axis, 0.0, 0.0)), STAGE_COVER, axis, BUDGET);
    return clear == WALK_COMPLETE ? CONE_CLEAR : cover == WALK_ENDED ? CONE_COVERED : CONE_MIXED;
}
