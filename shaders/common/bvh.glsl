// SPDX-License-Identifier: MIT
// Shadow rays against the hierarchy of host/bvh/bvh.h (the texel layout is documented there): any hit ends the ray.
//
// The walk itself is common/bvh_path.glsl's. docs/bvh.md has what was measured.
//
// Includer declares: what common/scene_words.glsl and common/bvh_alpha.glsl need; ASKS_VIEWER, where rays are of pixels, with what
// common/looked_through.glsl needs: else nobody is asked, and bvh_ray_of_pixel() is to be given 0.
#ifndef BVH_GLSL
#define BVH_GLSL
#include "common/bvh_alpha.glsl"
#include "common/bvh_leaf.glsl"
#include "common/bvh_path.glsl"
#include "common/bvh_triangle.glsl"
#ifdef ASKS_VIEWER
#include "common/looked_through.glsl"
#endif

// Where the light grazes what rises past a triangle's end, a ray that starts below meets it farther along than the start lies past that.
const float ASKED_PER_BEYOND = 8.0;

// Of a pixel, whose start may lie past the end of what it is on by `beyond_edge_m`, under a neighbour that hides nothing then.
BvhRay bvh_ray_of_pixel(vec3 start, float beyond_edge_m, vec3 direction, float t_min, float t_max) {
    BvhRay ray = bvh_ray(start, direction, t_min, t_max);
    ray.t_asked = ASKED_PER_BEYOND * beyond_edge_m * inversesqrt(dot(direction, direction));
    return ray;
}

// `unsure`: bit 0 and 1, the triangles of which bvh_hits_unsure() has to say whether they are hit, if none is for sure.
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
        const vec3 a = first ? corners.a : corners.c, c = first ? corners.c : corners.d;
        bool hit = bvh_plane_ahead(ray, a, corners.b, c, t);
#ifdef ASKS_VIEWER
        const float beyond_edge_m = ray.t_asked * length(ray.direction) / ASKED_PER_BEYOND;
        if (ray.t_asked > 0.0 && hit && is_looked_through(ray.origin, beyond_edge_m, a, corners.b, c)) hit = false;
#endif
        if (hit) found = true;
        if (hit) t_hit = t;
        leaves.x &= ~(first ? 1u : 2u);
        if ((leaves.x & 3u) == 0u) leaves = uvec4(leaves.yzw, 0u);
    }
    return found;
}

#include "common/bvh_boxes.glsl"

// occluded_at() of a ray that is made.
bool bvh_occluded(BvhRay ray, inout float t_hit) {
    BvhPath path = bvh_path(ray.direction);
    bool found = false;
    // The last leaves that are hit or not for digits that are not there, or near the start of a pixel's ray. Decided after the loop, since a device without
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

// Whether anything lies on the ray between t_min and t_max (exclusive, t_min >= 0); both sides of a triangle block.
// `direction` is finite and of any length but zero, the unit of t; t_max may be infinite. `t_hit` becomes where some such
// thing lies, not the nearest, and costs nothing where nobody reads it; without one it stays what it was.
bool occluded_at(vec3 origin, vec3 direction, float t_min, float t_max, inout float t_hit) {
    return bvh_occluded(bvh_ray(origin, direction, t_min, t_max), t_hit);
}

// .. of a pixel's ray (bvh_ray_of_pixel()).
bool occluded_from(vec3 start, float beyond_edge_m, vec3 direction, float t_min, float t_max, inout float t_hit) {
    return bvh_occluded(bvh_ray_of_pixel(start, beyond_edge_m, direction, t_min, t_max), t_hit);
}

bool occluded(vec3 origin, vec3 direction, float t_min, float t_max) {
    float unread = 0.0;
    return occluded_at(origin, direction, t_min, t_max, unread);
}
#endif
