// SPDX-License-Identifier: MIT
// The nearest triangle on a ray, of the hierarchy of host/bvh/bvh.h: common/bvh.glsl's walk, nearest children first, which ends
// where nothing nearer can come.
//
// Includer has common/bvh.glsl.

struct BvhHit {
    bool found;
    float t;
    uint leaf, which;  // 0: v0, v1, v2; 1: v2, v1, v3
};

void bvh_keep_nearer(inout BvhHit hit, inout BvhRay ray, uint leaf, uint which, float t) {
    if (!(t < ray.t_max)) return;
    hit = BvhHit(true, t, leaf, which);
    ray.t_max = t;
}

// `unsure`: as bvh_hits_leaf() has it.
void bvh_nearest_of_leaf(inout BvhHit hit, inout BvhRay ray, uint leaf, out uint unsure) {
    const BvhLeaf corners = bvh_leaf(leaf);
    const vec3 a = bvh_shear(ray, corners.a), b = bvh_shear(ray, corners.b), c = bvh_shear(ray, corners.c), d = bvh_shear(ray, corners.d);
    const float ab = bvh_edge(a, b), bc = bvh_edge(b, c), ca = bvh_edge(c, a), bd = bvh_edge(b, d), dc = bvh_edge(d, c);
    float t_first = ray.t_max, t_second = ray.t_max;
    uint first = bvh_inside(ray, vec3(bc, ca, ab), a, b, c, t_first);
    uint second = bvh_inside(ray, vec3(bd, dc, -bc), c, b, d, t_second);
#ifndef NO_SCENE_ALPHA
    if (HAS_SCENE_ALPHA) {
        if (first != BVH_MISS && !bvh_alpha_blocks(leaf, 0u, vec3(bc, ca, ab))) first = BVH_MISS;
        if (second != BVH_MISS && !bvh_alpha_blocks(leaf, 1u, vec3(bd, dc, -bc))) second = BVH_MISS;
    }
#endif
    if (first == BVH_HIT) bvh_keep_nearer(hit, ray, leaf, 0u, t_first);
    if (second == BVH_HIT) bvh_keep_nearer(hit, ray, leaf, 1u, t_second);
    unsure = first >> 1 | second & 2u;
}

// t_min, t_max and direction as occluded_at() has them. What only bvh_plane_ahead() can decide lies at the ray's start,
// nearer than most hits; it is decided last, for the same reason as there.
BvhHit bvh_closest(vec3 origin, vec3 direction, float t_min, float t_max) {
    BvhRay ray = bvh_ray(origin, direction, t_min, t_max);
    BvhPath path = bvh_path(-direction);  // which is ordered for the far end
    BvhHit hit = BvhHit(false, t_max, 0u, 0u);
    uvec4 unsure_leaves = uvec4(0u);
    while (true) {
        if (bvh_at_leaf(path)) {
            const uint leaf = bvh_take_leaf(path);
            uint unsure;
            bvh_nearest_of_leaf(hit, ray, leaf, unsure);
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
    while (unsure_leaves.x != 0u) {
        const BvhLeaf corners = bvh_leaf(unsure_leaves.x >> 2);
        const bool first = (unsure_leaves.x & 1u) != 0u;
        float t;
        if (bvh_plane_ahead(ray, first ? corners.a : corners.c, corners.b, first ? corners.c : corners.d, t))
            bvh_keep_nearer(hit, ray, unsure_leaves.x >> 2, first ? 0u : 1u, max(t, t_min));
        unsure_leaves.x &= ~(first ? 1u : 2u);
        if ((unsure_leaves.x & 3u) == 0u) unsure_leaves = uvec4(unsure_leaves.yzw, 0u);
    }
    return hit;
}
