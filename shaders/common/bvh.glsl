// SPDX-License-Identifier: MIT
// Shadow rays against the hierarchy of host/bvh/bvh.h (the texel layout is documented there): any hit ends the ray.
//
// The walk itself is common/bvh_path.glsl's. docs/bvh.md has what was measured.
//
// Includer declares: what common/scene_words.glsl and common/bvh_alpha.glsl need.
#ifndef BVH_GLSL
#define BVH_GLSL
#include "common/bvh_alpha.glsl"
#include "common/bvh_leaf.glsl"
#include "common/bvh_path.glsl"
#include "common/bvh_triangle.glsl"

// `unsure`: bit 0 and 1, the triangles of which bvh_plane_ahead() has to say whether they are hit, if none is for sure.
bool bvh_hits_leaf(BvhRay ray, uint leaf, BvhLeaf corners, inout float t_hit, out uint unsure) {
    vec3 a = bvh_shear(ray, corners.a), b = bvh_shear(ray, corners.b), c = bvh_shear(ray, corners.c), d = bvh_shear(ray, corners.d);
    float ab = bvh_edge(a, b), bc = bvh_edge(b, c), ca = bvh_edge(c, a), bd = bvh_edge(b, d), dc = bvh_edge(d, c);
    uint first, second;
#ifndef NO_SCENE_ALPHA
    if (HAS_SCENE_ALPHA) {
        float t_first = t_hit, t_second = t_hit;
        first = bvh_inside(ray, vec3(bc, ca, ab), a, b, c, t_first);
        second = bvh_inside(ray, vec3(bd, dc, -bc), c, b, d, t_second);
        if (first != BVH_MISS && !bvh_alpha_blocks(leaf, 0u, vec3(bc, ca, ab))) first = BVH_MISS;
        if (second != BVH_MISS && !bvh_alpha_blocks(leaf, 1u, vec3(bd, dc, -bc))) second = BVH_MISS;
        if (first == BVH_HIT) t_hit = t_first;
        if (second == BVH_HIT) t_hit = t_second;
    } else
#endif
    {
        first = bvh_inside(ray, vec3(bc, ca, ab), a, b, c, t_hit);
        second = bvh_inside(ray, vec3(bd, dc, -bc), c, b, d, t_hit);
    }
    unsure = first >> 1 | second & 2u;
    return first == BVH_HIT || second == BVH_HIT;
}

// Decides what bvh_hits_leaf() could not: of up to four leaves, each as index << 2 | its triangles in question.
bool bvh_hits_unsure(BvhRay ray, uvec4 leaves, inout float t_hit) {
    bool found = false;
    while (leaves.x != 0u) {
        BvhLeaf corners = bvh_leaf(leaves.x >> 2);
        bool first = (leaves.x & 1u) != 0u;
        float t;
        bool hit = bvh_plane_ahead(ray, first ? corners.a : corners.c, corners.b, first ? corners.c : corners.d, t);
        if (hit) found = true;
        if (hit) t_hit = t;
        leaves.x &= ~(first ? 1u : 2u);
        if ((leaves.x & 3u) == 0u) leaves = uvec4(leaves.yzw, 0u);
    }
    return found;
}

#include "common/bvh_boxes.glsl"

// Whether anything lies on the ray between t_min and t_max (exclusive, t_min >= 0); both sides of a triangle block.
// `direction` is finite and of any length but zero, the unit of t; t_max may be infinite. `t_hit` becomes where some such
// thing lies, not the nearest, and costs nothing where nobody reads it; without one it stays what it was.
bool occluded_at(vec3 origin, vec3 direction, float t_min, float t_max, inout float t_hit) {
    const BvhRay ray = bvh_ray(origin, direction, t_min, t_max);
    BvhPath path = bvh_path(direction);
    bool found = false;
    // The last leaves that are hit or not for digits that are not there. Decided after the loop, since a device without
    // branches would decide in every step of every ray; a fifth such leaf takes the place of the first.
    uvec4 unsure_leaves = uvec4(0u);
    while (true) {
        if (bvh_at_leaf(path)) {
            uint leaf = bvh_take_leaf(path), unsure;
            if (bvh_hits_leaf(ray, leaf, bvh_leaf(leaf), t_hit, unsure)) found = true;
            if (unsure != 0u) unsure_leaves = uvec4(leaf << 2 | unsure, unsure_leaves.xyz);
        }
        BvhVisit visit = bvh_visit(path);
        if (visit.wanted) {
            bvh_fetch(path, visit);
            visit.hits = bvh_hit_children(ray, visit.n0, visit.n1, visit.n2);
        }
        bvh_go_on(path, visit);
        if (found || bvh_ended(path)) break;
    }
    if (!found && unsure_leaves.x != 0u) found = bvh_hits_unsure(ray, unsure_leaves, t_hit);
    return found;
}

bool occluded(vec3 origin, vec3 direction, float t_min, float t_max) {
    float unread = 0.0;
    return occluded_at(origin, direction, t_min, t_max, unread);
}
#endif
