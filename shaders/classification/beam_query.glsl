// SPDX-License-Identifier: MIT
// One question to the hierarchy of host/bvh/bvh.h for many pixels at once: does the beam of all their shadow rays meet nothing, is it
// blocked by a surface that closes it off (closing_patch.glsl), or neither? The beam is a cone that is as wide as the
// pixels at its start and so contains the cones of all of them; whatever it does not meet, no ray of theirs meets. A beam that
// has met something is followed along its axis only: what remains to be found is a cover.
// The surface that the pixels lie on would touch every beam. Two bounds of where rays start tell it from casters: a
// triangle whose plane has all starts on the side that the rays go to is behind them. The bounds are a disc across the sun
// and a box along the surface, which is flat where the pixels are.
// Nothing met: all lit. Closed off: all shadowed. Else the tile is left to its pixels.
//
// Includer declares: what common/bvh.glsl needs; uniform usamplerBuffer neighbours; const uint PATCH (triangles), BUDGET
// (steps).
#define SHARED_STACK
#include "common/bvh.glsl"
#include "classification/cone.glsl"
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

Walk beam_walk(Cone cone, Starts starts) {
    const vec3 axis = cone.frame[2];
    return Walk(cone, starts, cone_slabs(axis, cone.spread, cone.radius), cone_slabs(axis, 0.0, 0.0), true, false);
}

const int BEHIND = 2;

// From which side all rays of the beam come to a triangle ahead of all starts: 1 or -1, opposite for opposite windings; BEHIND
// if they cannot meet it, since they start on the far side and lead away; 0 where they do not all cross its plane the same way, or
// not for certain.
int beam_side(Walk walk, vec3 a, vec3 b, vec3 c) {
    const vec3 ab = b - a, ac = c - a;
    const vec3 n = cross(ab, ac);
    // From the nearest corner, over which a tilt of the plane shows least.
    const vec3 starts = walk.starts.centre;
    vec3 from = starts - a;
    if (dot(starts - b, starts - b) < dot(from, from)) from = starts - b;
    if (dot(starts - c, starts - c) < dot(from, from)) from = starts - c;
    const float extent = abs(dot(n, walk.starts.u)) + abs(dot(n, walk.starts.v)) + abs(dot(n, walk.starts.w));
    // Rays start few roundings above their own surface (common/ray_offset.glsl), so that here CONE_ROUNDING's sums would see no start
    // above anything: a corner in this frame is off by one rounding of itself in the subtraction and 3 sqrt(3) in the turn, and, as
    // seen from the starts, by two of the apex. By twice that on either edge the normal is; by four roundings more it is multiplied.
    const float corner = ROUNDING * (8.0 * sqrt(max(dot(a, a), max(dot(b, b), dot(c, c)))) + 2.0 * taxicab(walk.cone.apex));
    const float n_error = 2.0 * corner * (length(ab) + length(ac)) + 4.0 * ROUNDING * length(ab) * length(ac);
    const float along = n.z < 0.0 ? -dot(n, from) : dot(n, from);
    const float error = n_error * (length(from) + walk.cone.radius) + length(n) * (corner + 4.0 * ROUNDING * length(from));
    const bool crossed = abs(n.z) > walk.cone.spread * length(n.xy) * 1.001 + n_error;
    if (!crossed) return 0;
    if (along - extent > error) return BEHIND;
    return along + extent < -error ? (n.z < 0.0 ? -1 : 1) : 0;
}

#include "classification/closing_patch.glsl"

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

// True ends the walk.
bool walk_leaf(inout Walk walk, uint leaf) {
    const BvhLeaf v = cone_leaf(walk.cone, leaf);
    const uint first = beam_meets(walk, v.a, v.b, v.c);
    uint second = MISSES_BEAM;
    if (v.d != v.c) second = beam_meets(walk, v.c, v.b, v.d);
    const bool pierced = first == PIERCED_BY_AXIS || second == PIERCED_BY_AXIS;
    if (pierced && covers(walk, leaf << 1 | uint(first != PIERCED_BY_AXIS))) walk.covered = true;
    if ((first | second) != MISSES_BEAM) walk.clean = false;
    return walk.covered;
}

// False where BUDGET steps were not enough to see everything.
bool walk_tree(inout Walk walk) {
    BvhPath path = bvh_path(walk.cone.frame[2]);
    bool done = false;
    uint steps = 0u;
    while (true) {
        if (bvh_at_leaf(path) && walk_leaf(walk, bvh_take_leaf(path))) done = true;
        BvhVisit visit = bvh_visit(path);
        if (visit.wanted) {
            bvh_fetch(path, visit);
            ConeSlabs slabs = walk.thin;
            if (walk.clean) slabs = walk.wide;
            visit.hits = cone_hit_children(slabs, walk.cone.apex, visit.n0, visit.n1, visit.n2);
        }
        bvh_go_on(path, visit);
        ++steps;
        if (done || steps >= BUDGET || bvh_ended(path)) break;
    }
    return done || bvh_ended(path);
}
