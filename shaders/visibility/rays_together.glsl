// SPDX-License-Identifier: MIT
// The shadow rays of a subgroup's lanes, by either backend. Where a pixel has several, which lie side by side, the lanes of some CPUs walk
// through the tree together; those of one ray per pixel, each from a surface of its own to another point of the sun, have too little in
// common (docs/notes/2026-11-29-what-lanes-can-say.md).
//
// Includer has the parameter backend, the extension GL_KHR_shader_subgroup_shuffle and SEVERAL_RAYS, and is compiled by class.
#if BACKEND == BACKEND_RAY_QUERY
#include "common/ray_query.glsl"
#else
#include "common/bvh.glsl"
#endif

#if CLASS_CPU && SEVERAL_RAYS && BACKEND != BACKEND_RAY_QUERY
#include "visibility/bvh_together.glsl"

// A ray is asked what another one asked for, too: it does not meet a leaf in a box that it passes by.
bool occluded_together(BvhRay ray, bool own, inout float t_hit) {
    BvhSharedPath path = bvh_shared_path(ray.direction);
    bool found = false, live = own;
    uvec4 unsure_leaves = uvec4(0u);  // as bvh_occluded() has them
    bool ended = !any_of_lanes(live);
    while (!ended) {
        uint bit;
        if (bvh_at_leaf(path)) {
            uint leaf, unsure;
            const BvhLeaf corners = bvh_take_leaf(path, bit, leaf);
            float t = t_hit;
            const bool hit = bvh_hits_leaf(ray, leaf, corners, t, unsure);
            if (live && unsure != 0u) unsure_leaves = uvec4(leaf << 2 | unsure, unsure_leaves.xyz);
            if (live && hit) {
                found = true;
                live = false;
                t_hit = t;
            }
        } else {
            const BvhTexels node = bvh_take_node(path, bit);
            bvh_go_on(path, node, live ? bvh_hit_children(ray, node.n0, node.n1, node.n2) : 0u);
        }
        ended = bvh_ended(path) || !any_of_lanes(live);
    }
    if (!found && unsure_leaves.x != 0u) found = bvh_hits_unsure(ray, unsure_leaves, t_hit);
    return found;
}
#endif

// As occluded_from(), of who is `own`; false for the others. All lanes take part.
bool occluded_beside(vec3 origin, float beyond_edge_m, vec3 direction, float t_min, float t_max, bool own, inout float t_hit) {
#if CLASS_CPU && SEVERAL_RAYS && BACKEND != BACKEND_RAY_QUERY
    if (LANES_WALK_TOGETHER) return occluded_together(bvh_ray_of_pixel(origin, beyond_edge_m, direction, t_min, t_max), own, t_hit);
#endif
    return own && occluded_from(origin, beyond_edge_m, direction, t_min, t_max, t_hit);
}
