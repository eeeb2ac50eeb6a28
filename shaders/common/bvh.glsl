// SPDX-License-Identifier: MIT
// Shadow rays against the hierarchy of host/bvh/bvh.h (the texel layout is documented there): any hit ends the ray.
//
// The walk itself is common/bvh_path.glsl's. docs/bvh.md has what was measured.
//
// Includer declares: uniform usamplerBuffer scene_nodes, scene_leaves; what common/bvh_alpha.glsl needs.
#include "common/bvh_alpha.glsl"
#include "common/bvh_path.glsl"
#include "common/twofold.glsl"

// What does not change along the ray. Woop, Benthin, Wald 2013: vertices are sheared so that the ray becomes the z axis;
// the rounding happens per vertex, so neighbours see the same rounded vertex and no gap opens between them.
struct BvhRay {
    vec3 origin, direction, inverse;
    float t_min, t_max;
    bool x_longest, z_longest;
    vec3 shear;  // x, y: slopes; z: 1 / longest component
};

BvhRay bvh_ray(vec3 origin, vec3 direction, float t_min, float t_max) {
    BvhRay ray;
    ray.origin = origin;
    ray.t_min = t_min;
    ray.t_max = t_max;
    // A zero would give 0 * inf in the slab test. The sign of zero does not matter: either side is within rounding.
    const float tiny = 8.271806125530277e-25;  // 2^-80
    vec3 d = mix(mix(vec3(tiny), vec3(-tiny), lessThan(direction, vec3(0))), direction,
                 greaterThanEqual(abs(direction), vec3(tiny)));
    ray.direction = d;
    ray.inverse = 1.0 / d;
    vec3 a = abs(d);
    ray.x_longest = a.x > a.y && a.x > a.z;
    ray.z_longest = !ray.x_longest && !(a.y > a.z);
    float x = ray.x_longest ? d.y : d.x;
    float y = ray.z_longest ? d.y : d.z;
    float scale = ray.x_longest ? ray.inverse.x : ray.z_longest ? ray.inverse.z : ray.inverse.y;
    precise vec2 slope = vec2(x, y) * scale;
    ray.shear = vec3(slope, scale);
    return ray;
}

// `precise` forbids fused multiply-add: with it, edge(a, b) = -edge(b, a) would no longer hold.
vec3 bvh_shear(BvhRay ray, vec3 vertex) {
    precise vec3 p = vertex - ray.origin;
    float px = ray.x_longest ? p.y : p.x;
    float py = ray.z_longest ? p.y : p.z;
    float pz = ray.x_longest ? p.x : ray.z_longest ? p.z : p.y;
    precise vec3 sheared = vec3(px - ray.shear.x * pz, py - ray.shear.y * pz, pz);
    return sheared;
}

float bvh_edge(vec3 a, vec3 b) {
    precise float e = a.x * b.y - a.y * b.x;
    return e;
}

// How far rounding can move a triangle's hit along the ray, times the triangle's sheared area: within it, on which side of
// the ray's start the triangle lies is not known. From Woop et al., each coordinate x = p_x - s_x p_z is off by
// u (2 |x| + 3 |s_x p_z|), u = 2^-24, an edge function a_x b_y - a_y b_x by u (10 X Y + 6 Z (|s_x| Y + |s_y| X)) with
// X, Y, Z the largest |x|, |y|, |z|, and t * area = sum of edge * z by its own rounding and by that times |z|. Where all
// corners are ahead, so is the hit. Else Z is at most the range of t, and the sum at most 40 u range (X Y + ..); errors
// do not all add up: taken for the truth, with 2 u 1 of 10 000 rays is still wrong, with 4 u none of 12 million
// (tests/bvh_large_planes_test.cpp).
const float bvh_hit_roundings = 4.0 * 5.9604644775390625e-8;

float bvh_hit_rounding(BvhRay ray, vec3 a, vec3 b, vec3 c) {
    precise vec3 t = vec3(a.z, b.z, c.z) * ray.shear.z;
    float first = min(min(t.x, t.y), t.z);
    precise float range = max(max(t.x, t.y), t.z) - first;
    vec2 xy = max(max(abs(a.xy), abs(b.xy)), abs(c.xy));
    precise float z = range / abs(ray.shear.z);
    precise float edges = xy.x * xy.y + z * (abs(ray.shear.x) * xy.y + abs(ray.shear.y) * xy.x);
    precise float rounding = bvh_hit_roundings * range * edges;
    return first > 0.0 ? 0.0 : rounding;
}

// What no arithmetic can undo: the corners themselves were rounded to the scene's frame, each by u of its coordinates, and
// their plane lies beside that of what was rasterised by as much. The ray's start keeps off the surface by what grows with
// its own coordinates; what grows with the distance of the corners it knows nothing of, and large receivers would shade
// themselves (the same test: 5000 rays of 12 million without, 0 with half of u). 1 u is the bound, the other the raster's.
const float bvh_vertex_roundings = 2.0 * 5.9604644775390625e-8;

// Whether the triangle's plane lies ahead of the ray's start by more than its corners' rounding; `t` is where. For a ray
// that is known to pass inside the triangle. t = n.(a - o) / n.d with 47 bits in n and in both products.
bool bvh_plane_ahead(BvhRay ray, vec3 a, vec3 b, vec3 c, out float t) {
    const Twofold to_a = twofold_difference(a, ray.origin);
    const Twofold n = cross_product(twofold_difference(b, a), twofold_difference(c, a));
    const float height = dot_product(n, to_a), slope = dot_product(n, Twofold(ray.direction, vec3(0.0)));
    precise vec3 reach = max(max(abs(to_a.hi), abs(b - ray.origin)), abs(c - ray.origin));
    float extent = max(max(reach.x, reach.y), reach.z);
    vec3 area = abs(n.hi), size = abs(ray.direction);
    precise float displaced = bvh_vertex_roundings * extent * ((area.x + area.y) + area.z);
    precise float turned = bvh_vertex_roundings * extent * extent * ((size.x + size.y) + size.z);
    precise float beyond = (slope < 0.0 ? -height : height) - ray.t_min * abs(slope);
    t = height / slope;
    return abs(slope) > turned && beyond > displaced;
}

const uint BVH_MISS = 0u, BVH_HIT = 1u, BVH_UNSURE = 2u;

// uvw: the edge functions opposite to a, b, c. One of exactly 0 counts for both triangles at the edge. A triangle seen
// edge-on, or degenerate, has all three at 0 and no area to hit. `t_hit` is changed by a hit alone.
uint bvh_inside(BvhRay ray, vec3 uvw, vec3 a, vec3 b, vec3 c, inout float t_hit) {
    bool miss = min(min(uvw.x, uvw.y), uvw.z) < 0.0 && max(max(uvw.x, uvw.y), uvw.z) > 0.0;
    precise float det = uvw.x + uvw.y + uvw.z;
    precise float t = (uvw.x * a.z + uvw.y * b.z + uvw.z * c.z) * ray.shear.z;
    precise float size = abs(det);
    float rounding = bvh_hit_rounding(ray, a, b, c);
    precise float near = ray.t_min * size;
    precise float surely = near + rounding;
    precise float at_all = near - rounding;
    precise float far = ray.t_max * size;
    float signed_t = det < 0.0 ? -t : t;
    const bool met = !miss && size > 0.0 && signed_t > at_all && signed_t < far, sure = met && signed_t > surely;
    if (sure) t_hit = signed_t / size;
    return sure ? BVH_HIT : met ? BVH_UNSURE : BVH_MISS;
}

struct BvhLeaf {
    vec3 a, b, c, d;  // triangles a, b, c and c, b, d
};

BvhLeaf bvh_leaf(uint leaf) {
    int texel = int(leaf * 3u);
    vec4 q0 = uintBitsToFloat(texelFetch(scene_leaves, texel));
    vec4 q1 = uintBitsToFloat(texelFetch(scene_leaves, texel + 1));
    vec4 q2 = uintBitsToFloat(texelFetch(scene_leaves, texel + 2));
    return BvhLeaf(q0.xyz, vec3(q0.w, q1.xy), vec3(q1.zw, q2.x), q2.yzw);
}

// `unsure`: bit 0 and 1, the triangles of which bvh_plane_ahead() has to say whether they are hit, if none is for sure.
bool bvh_hits_leaf(BvhRay ray, uint leaf, inout float t_hit, out uint unsure) {
    BvhLeaf corners = bvh_leaf(leaf);
    vec3 a = bvh_shear(ray, corners.a), b = bvh_shear(ray, corners.b), c = bvh_shear(ray, corners.c), d = bvh_shear(ray, corners.d);
    float ab = bvh_edge(a, b), bc = bvh_edge(b, c), ca = bvh_edge(c, a), bd = bvh_edge(b, d), dc = bvh_edge(d, c);
    uint first, second;
#ifndef NO_SCENE_ALPHA
    if (HAS_SCENE_ALPHA_UV) {
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

vec4 bvh_planes(uint word, float step, float base) {
    return vec4(uvec4(word, word >> 8, word >> 16, word >> 24) & 255u) * step + base;
}

// Children that the ray's box test passes, bit k for child k. The grid is conservative (host/bvh/bvh.cpp); the factor is Ize
// 2013, "Robust BVH Ray Traversal", widened to cover the shear's rounding too.
uint bvh_hit_children(BvhRay ray, uvec4 n0, uvec4 n1, uvec4 n2) {
    vec3 step = uintBitsToFloat((uvec3(n0.w, n0.w >> 8, n0.w >> 16) & 255u) << 23) * ray.inverse;
    vec3 base = (uintBitsToFloat(n0.xyz) - ray.origin) * ray.inverse;
    bvec3 negative = lessThan(ray.inverse, vec3(0));
    vec4 near = bvh_planes(negative.x ? n1.w : n1.z, step.x, base.x);
    vec4 far = bvh_planes(negative.x ? n1.z : n1.w, step.x, base.x);
    near = max(near, bvh_planes(negative.y ? n2.y : n2.x, step.y, base.y));
    far = min(far, bvh_planes(negative.y ? n2.x : n2.y, step.y, base.y));
    near = max(near, bvh_planes(negative.z ? n2.w : n2.z, step.z, base.z));
    far = min(far, bvh_planes(negative.z ? n2.z : n2.w, step.z, base.z));
    near = max(near, vec4(ray.t_min));
    far = min(far, vec4(ray.t_max)) * 1.000002;
    uvec4 hit = mix(uvec4(0), uvec4(1, 2, 4, 8), lessThanEqual(near, far));
    return hit.x | hit.y | hit.z | hit.w;
}

// Whether anything lies on the ray between t_min and t_max (exclusive, t_min >= 0); both sides of a triangle block.
// `direction` is finite and of any length but zero, the unit of t; t_max may be infinite. `t_hit` becomes where some such
// thing lies, not the nearest, and costs nothing where nobody reads it; without one it stays what it was. So does `leaf_hit`,
// which becomes its leaf, unless only bvh_plane_ahead() knew.
bool occluded_by(vec3 origin, vec3 direction, float t_min, float t_max, inout float t_hit, inout uint leaf_hit) {
    const BvhRay ray = bvh_ray(origin, direction, t_min, t_max);
    BvhPath path = bvh_path(direction);
    bool found = false;
    // The last leaves that are hit or not for digits that are not there. Decided after the loop, since a device without
    // branches would decide in every step of every ray; a fifth such leaf takes the place of the first.
    uvec4 unsure_leaves = uvec4(0u);
    while (true) {
        if (bvh_at_leaf(path)) {
            uint leaf = bvh_take_leaf(path), unsure;
            const bool hit = bvh_hits_leaf(ray, leaf, t_hit, unsure);
            if (hit) found = true;
            if (hit) leaf_hit = leaf;
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

bool occluded_at(vec3 origin, vec3 direction, float t_min, float t_max, inout float t_hit) {
    uint unread = 0u;
    return occluded_by(origin, direction, t_min, t_max, t_hit, unread);
}

bool occluded(vec3 origin, vec3 direction, float t_min, float t_max) {
    float unread = 0.0;
    return occluded_at(origin, direction, t_min, t_max, unread);
}
