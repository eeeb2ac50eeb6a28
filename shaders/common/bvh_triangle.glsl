// SPDX-License-Identifier: MIT
// A shadow ray against a triangle: watertight at edges, and sure of which side of the ray's start it lies on, or said not to be.
#include "common/twofold.glsl"

// What does not change along the ray. Woop, Benthin, Wald 2013: vertices are sheared so that the ray becomes the z axis;
// the rounding happens per vertex, so neighbours see the same rounded vertex and no gap opens between them.
struct BvhRay {
    vec3 origin, direction, inverse;
    float t_min, t_max;
    float t_asked;  // of a pixel's: nearer than that nothing is hit that the viewer looks through (bvh_ray_of_pixel()); else 0
    bool x_longest, z_longest;
    vec3 shear;  // x, y: slopes; z: 1 / longest component
};

BvhRay bvh_ray(vec3 origin, vec3 direction, float t_min, float t_max) {
    BvhRay ray;
    ray.origin = origin;
    ray.t_min = t_min;
    ray.t_max = t_max;
    ray.t_asked = 0.0;
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
// do not all add up: of 36 million rays that start on a large triangle with no bound at all 51 are wrong with 5 u, none with
// 6 u (tests/bvh_large_planes_test.cpp has a part of them).
const float bvh_hit_roundings = 8.0 * 5.9604644775390625e-8;

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
    precise float surely = max(near + rounding, ray.t_asked * size);
    precise float at_all = near - rounding;
    precise float far = ray.t_max * size;
    float signed_t = det < 0.0 ? -t : t;
    const bool met = !miss && size > 0.0 && signed_t > at_all && signed_t < far, sure = met && signed_t > surely;
    if (sure) t_hit = signed_t / size;
    return sure ? BVH_HIT : met ? BVH_UNSURE : BVH_MISS;
}
