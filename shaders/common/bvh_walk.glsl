// SPDX-License-Identifier: MIT
// The walk through the hierarchy for other questions than a ray's: what passes a node and what a leaf means is the
// includer's.
//
// Includer has common/bvh.glsl and defines: struct Walk, the question and what is known so far.

// Children of a node that matter, bit k for child k.
uint walk_children(Walk walk, uvec4 n0, uvec4 n1, uvec4 n2);
// Looks at a leaf; true ends the walk.
bool walk_leaf(inout Walk walk, uint leaf);

// Children far along `direction` come first. False where `budget` steps were not enough to see everything.
bool walk_tree(inout Walk walk, vec3 direction, uint budget) {
    BvhPath path = bvh_path(direction);
    bool done = false;
    uint steps = 0u;
    while (true) {
        if (bvh_at_leaf(path) && walk_leaf(walk, bvh_take_leaf(path))) done = true;
        BvhVisit visit = bvh_visit(path);
        if (visit.wanted) {
            bvh_fetch(path, visit);
            visit.hits = walk_children(walk, visit.n0, visit.n1, visit.n2);
        }
        bvh_go_on(path, visit);
        ++steps;
        if (done || steps >= budget || bvh_ended(path)) break;
    }
    return done || bvh_ended(path);
}
