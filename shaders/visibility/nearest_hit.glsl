// SPDX-License-Identifier: MIT
// The nearest thing on a ray, for those who want to know how far away a blocker is and not only that there is one. The same
// triangles and the same tests as those of common/bvh.glsl, in a walk that begins at the ray's start and shortens the ray at each hit.
//
// Includer declares: constant BACKEND; what common/bvh.glsl or common/ray_query.glsl needs.
#if BACKEND == BACKEND_RAY_QUERY
#define NEAREST_HIT
#include "common/ray_query.glsl"

bool nearest_hit(vec3 start, float beyond_edge_m, vec3 direction, float t_min, float t_max, inout float t_hit) {
    return occluded_at(start, direction, t_min, t_max, t_hit);
}
#else
#include "common/bvh.glsl"

// Parameters and result as those of occluded_from(), but `t_hit` becomes where the first of all things lies.
bool nearest_hit(vec3 start, float beyond_edge_m, vec3 direction, float t_min, float t_max, inout float t_hit) {
    BvhRay ray = bvh_ray_of_pixel(start, beyond_edge_m, direction, t_min, t_max);
    BvhPath path = bvh_path(-direction);
    bool found = false;
    uvec4 unsure_leaves = uvec4(0u);  // as in bvh_occluded(); they lie at the ray's start, so nothing is nearer
    while (true) {
        if (bvh_at_leaf(path)) {
            const uint pending = path.leaf_mask;
            uint leaf = bvh_take_leaf(path), unsure;
            float t = ray.t_max;
            if (bvh_hits_leaf(ray, leaf, bvh_leaf(leaf), t, unsure)) {
                found = true;
                if (t < ray.t_max) path.leaf_mask = pending;  // again: the other triangle of the two may be nearer still
                ray.t_max = min(t, ray.t_max);
            }
            if (unsure != 0u) unsure_leaves = uvec4(leaf << 2 | unsure, unsure_leaves.xyz);
        }
        BvhVisit visit = bvh_visit(path);
        if (visit.wanted) {
            bvh_fetch(path, visit);
            visit.hits = bvh_hit_children(ray, visit.n0, visit.n1, visit.n2);
        }
        bvh_go_on(path, visit);
        if (bvh_ended(path)) break;
    }
    if (found) t_hit = ray.t_max;
    return (unsure_leaves.x != 0u && bvh_hits_unsure(ray, unsure_leaves, t_hit)) || found;
}
#endif
