// SPDX-License-Identifier: MIT
// A ray against the boxes of a node of the hierarchy of host/bvh/bvh.h.
//
// Includer has common/bvh_triangle.glsl.
#include "common/bit_order.glsl"

vec4 bvh_planes(uint word, float step, float base) {
    return vec4(uvec4(word, word >> 8, word >> 16, word >> 24) & 255u) * step + base;
}

// Steps of a float by which an interval is taken to be longer, 2 to 4 millionths of its end. Ize 2013, "Robust BVH Ray Traversal", widened to
// cover the shear's rounding too.
const int SLACK = 34;

// Bit k: whether the k-th box has anything between `near`, which is not negative, and `far`. One that ends at -0 has nothing, which is right of
// what lies in it: boxes keep a distance from their planes (host/bvh/bvh.cpp).
uint bvh_hits(vec4 near, vec4 far) {
    const uvec4 hit = mix(uvec4(1, 2, 4, 8), uvec4(0), greaterThan(floatBitsToInt(near), floatBitsToInt(far) + SLACK));
    return hit.x | hit.y | hit.z | hit.w;
}

// Children that the ray's box test passes, bit k for child k. The grid is conservative (host/bvh/bvh.cpp).
uint bvh_hit_children(BvhRay ray, uvec4 n0, uvec4 n1, uvec4 n2) {
    vec3 step = uintBitsToFloat((uvec3(n0.w, n0.w >> 8, n0.w >> 16) & 255u) << 23) * ray.inverse;
    vec3 base = (uintBitsToFloat(n0.xyz) - ray.origin) * ray.inverse;
    bvec3 negative = lessThan(ray.inverse, vec3(0));
    vec4 near = bvh_planes(negative.x ? n1.w : n1.z, step.x, base.x);
    vec4 far = bvh_planes(negative.x ? n1.z : n1.w, step.x, base.x);
    near = bit_max(near, bvh_planes(negative.y ? n2.y : n2.x, step.y, base.y));
    far = bit_min(far, bvh_planes(negative.y ? n2.x : n2.y, step.y, base.y));
    near = bit_max(near, bvh_planes(negative.z ? n2.w : n2.z, step.z, base.z));
    far = bit_min(far, bvh_planes(negative.z ? n2.z : n2.w, step.z, base.z));
    near = bit_max(near, vec4(ray.t_min));
    return bvh_hits(near, bit_min(far, vec4(ray.t_max)));
}
