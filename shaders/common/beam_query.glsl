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
    ConeSlabs wide, thin;  // of the beam and of its axis
    bool clean;            // nothing has been met
    bool covered;
};
#include "common/bvh_walk.glsl"
#include "common/closing_patch.glsl"

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

uint walk_children(Walk walk, uvec4 n0, uvec4 n1, uvec4 n2) {
    ConeSlabs slabs = walk.thin;
    if (walk.clean) slabs = walk.wide;
    return cone_hit_children(slabs, walk.cone.apex, n0, n1, n2);
}

const uint MISSES_BEAM = 0u;
const uint MEETS_BEAM = 1u;
const uint PIERCED_BY_AXIS = 2u;  // for certain, ahead of all starts

uint beam_meets(Walk walk, vec3 a, vec3 b, vec3 c) {
    const int side = beam_side(walk, a, b, c);
    if (side == BEHIND || max(max(a.z, b.z), c.z) < -CONE_ROUNDING * (taxicab(a) + taxicab(b) + taxicab(c)))
        return MISSES_BEAM;
    const uint pierces = axis_passes(axis_side(b, c), axis_side(c, a), axis_side(a, b), a, b, c);
    if (pierces == PIERCES && side != 0) return PIERCED_BY_AXIS;
    return pierces != PIERCES_NOT || edge_meets_cone(walk.cone, a, b) || edge_meets_cone(walk.cone, b, c) ||
                   edge_meets_cone(walk.cone, c, a)
               ? MEETS_BEAM
               : MISSES_BEAM;
}

bool walk_leaf(inout Walk walk, uint leaf) {
    const Leaf v = cone_leaf(walk.cone, leaf);
    const uint first = beam_meets(walk, v.v0, v.v1, v.v2);
    uint second = MISSES_BEAM;
    if (v.v3 != v.v2) second = beam_meets(walk, v.v2, v.v1, v.v3);
    const bool pierced = first == PIERCED_BY_AXIS || second == PIERCED_BY_AXIS;
    if (pierced && covers(walk, leaf << 1 | uint(first != PIERCED_BY_AXIS))) walk.covered = true;
    if ((first | second) != MISSES_BEAM) walk.clean = false;
    return walk.covered;
}
