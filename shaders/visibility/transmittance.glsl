// SPDX-License-Identifier: MIT
// What translucent triangles leave of the light along a ray: the product of their transmittances, in any order, since every one of
// them is met. They have a tree of their own (host/scene/scene_translucents.h), which the walk of common/bvh_path.glsl goes through
// while in_translucents is set, and with the backend bvh the scene's tree while it is not.
//
// Includer declares: uniform usamplerBuffer translucents, translucent_texels; constants BACKEND and HAS_TRANSLUCENTS; what
// common/bvh.glsl or common/ray_query.glsl needs.
bool in_translucents = false;

#if BACKEND == BACKEND_BVH
#define scene_node_texel opaque_node_texel
#define scene_leaf_texel opaque_leaf_texel
#include "common/scene_words.glsl"
#undef scene_node_texel
#undef scene_leaf_texel
#else
#define SCENE_WORDS_GLSL
uvec4 opaque_node_texel(int texel) { return uvec4(0u); }  // the driver's, and never asked
uvec4 opaque_leaf_texel(int texel) { return uvec4(0u); }
#endif

uvec4 scene_node_texel(int texel) {
    if (HAS_TRANSLUCENTS && in_translucents) return texelFetch(translucents, 1 + texel);
    return opaque_node_texel(texel);
}

uvec4 scene_leaf_texel(int texel) {
    if (HAS_TRANSLUCENTS && in_translucents) return texelFetch(translucents, int(texelFetch(translucents, 0).x) + texel);
    return opaque_leaf_texel(texel);
}

#if BACKEND == BACKEND_RAY_QUERY
#include "common/ray_query.glsl"
#include "common/bvh_leaf.glsl"
#include "common/bvh_path.glsl"
#include "common/bvh_triangle.glsl"
#include "common/bvh_boxes.glsl"
#else
#include "common/bvh.glsl"
#endif
#include "common/cone_slabs.glsl"

const float TRANSMITTANCE_STEPS = 1023.0;  // of a channel of a texel

vec3 unpack_transmittance(uint texel) {
    return vec3(texel & 1023u, texel >> 10 & 1023u, texel >> 20 & 1023u) / TRANSMITTANCE_STEPS;
}

uint pack_transmittance(vec3 t) {
    const uvec3 steps = uvec3(t * TRANSMITTANCE_STEPS + 0.5);
    return steps.x | steps.y << 10 | steps.z << 20;
}

// By selection: to index a vector, devices put it into memory.
float component(vec3 v, uint i) { return i == 0u ? v.x : i == 1u ? v.y : v.z; }

// Of triangle `which` of a leaf; `areas` as bvh_alpha_blocks() has them.
vec3 triangle_transmittance(uint leaf, uint which, vec3 areas) {
    const uvec4 places = texelFetch(translucents, 0);
    const uvec4 words = texelFetch(translucents, int(places.y + (leaf >> 1)));
    const uvec2 of_leaf = (leaf & 1u) == 0u ? words.xy : words.zw;
    const uint word = which == 0u ? of_leaf.x : of_leaf.y, corner0 = word & 3u, corner1 = word >> 2 & 3u;
    const vec3 weights = vec3(component(areas, corner0), component(areas, corner1), component(areas, 3u - corner0 - corner1)) /
                         (areas.x + areas.y + areas.z);
    const int record = int(places.z + 2u * ((word >> 4) - 1u));
    const uvec4 r0 = texelFetch(translucents, record), r1 = texelFetch(translucents, record + 1);
    const vec2 uv = weights.x * uintBitsToFloat(r0.xy) + weights.y * uintBitsToFloat(r0.zw) + weights.z * uintBitsToFloat(r1.xy);
    const uvec2 size = uvec2(r1.w & 0xffffu, r1.w >> 16) + 1u, at = uvec2(mask_texel(uv, size));
    return unpack_transmittance(texelFetch(translucent_texels, int(r1.z + at.y * size.x + at.x)).x);
}

// Of both triangles of a leaf. Of their common edge, which both meet, the first has the ray. What lies within rounding of the ray's
// start is the surface that it starts on.
vec3 leaf_transmittance(BvhRay ray, uint leaf, inout float t_first) {
    const BvhLeaf corners = bvh_leaf(leaf);
    const vec3 a = bvh_shear(ray, corners.a), b = bvh_shear(ray, corners.b), c = bvh_shear(ray, corners.c), d = bvh_shear(ray, corners.d);
    const float ab = bvh_edge(a, b), bc = bvh_edge(b, c), ca = bvh_edge(c, a), bd = bvh_edge(b, d), dc = bvh_edge(d, c);
    float t = t_first, t_other = t_first;
    const bool first = bvh_inside(ray, vec3(bc, ca, ab), a, b, c, t) == BVH_HIT;
    const bool second = bvh_inside(ray, vec3(bd, dc, -bc), c, b, d, t_other) == BVH_HIT && !(first && bc == 0.0);
    t_first = min(t_first, min(t, t_other));
    vec3 transmittance = vec3(1.0);
    if (first) transmittance = triangle_transmittance(leaf, 0u, vec3(bc, ca, ab));
    if (second) transmittance *= triangle_transmittance(leaf, 1u, vec3(bd, dc, -bc));
    return transmittance;
}

// `t_first` becomes where the first of them lies, if that is less. `all`: though one that lets nothing through has been met, which need not
// be the first.
vec3 transmittance_along(vec3 origin, vec3 direction, float t_max, bool all, inout float t_first) {
    in_translucents = true;
    const BvhRay ray = bvh_ray(origin, direction, 0.0, t_max);
    BvhPath path = bvh_path(direction);
    vec3 transmittance = vec3(1.0);
    while (true) {
        if (bvh_at_leaf(path)) transmittance *= leaf_transmittance(ray, bvh_take_leaf(path), t_first);
        BvhVisit visit = bvh_visit(path);
        if (visit.wanted) {
            bvh_fetch(path, visit);
            visit.hits = bvh_hit_children(ray, visit.n0, visit.n1, visit.n2);
        }
        bvh_go_on(path, visit);
        if ((!all && transmittance == vec3(0.0)) || bvh_ended(path)) break;
    }
    in_translucents = false;
    return transmittance;
}

vec3 transmittance_along(vec3 origin, vec3 direction, float t_max) {
    float unread = t_max;
    return transmittance_along(origin, direction, t_max, false, unread);
}

// Whether a cone may meet a translucent triangle: it meets the box of one.
bool may_meet_translucents(ConeSlabs slabs, vec3 start, vec3 axis, bool wanted) {
    in_translucents = true;
    BvhPath path = bvh_path(axis);
    bool met = false, ended = !wanted;
    while (!ended) {
        BvhVisit visit = bvh_visit(path);
        bvh_fetch(path, visit);
        visit.hits = cone_hit_children(slabs, start, visit.n0, visit.n1, visit.n2);
        bvh_go_on(path, visit);
        if (bvh_at_leaf(path)) met = true;
        if (met || bvh_ended(path)) ended = true;
    }
    in_translucents = false;
    return met;
}
