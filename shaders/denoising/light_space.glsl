// SPDX-License-Identifier: MIT
// What a patch of the image looks like from the sun. Light space is metres along the axes of sun_frame(): x and y across
// the light, z towards the sun, camera-relative. A ray to the sun's point xi (a disc of radius 1) of a receiver at L, z
// passes height h at L + (h - z) tan(angular radius) xi.
//
#include "common/sun_sample.glsl"
#include "common/view_rays.glsl"

// How the seen point moves per pixel along x and y if the surface is the plane with this normal. Seen edge-on, a plane
// has no such derivative; the limit is that of 1 degree.
const float EDGE_ON = 0.0175;

mat2x3 tangents(ViewRays v, float view_depth, vec3 n) {
    const float facing = dot(n, v.r), least = EDGE_ON * length(v.r);
    const float by_facing = 1.0 / (facing < 0.0 ? min(facing, -least) : max(facing, least));
    const vec3 x = v.ox + view_depth * v.rx, y = v.oy + view_depth * v.ry;
    return mat2x3(x - v.r * (dot(n, x) * by_facing), y - v.r * (dot(n, y) * by_facing));
}

// A 2x2 map as two stretches: unit vectors along the image axes and how long their images are, the larger first.
struct Stretches {
    vec2 first, second;
    float s1, s2;
};

Stretches stretches_of(mat2 j) {
    const float a = dot(j[0], j[0]), b = dot(j[0], j[1]), c = dot(j[1], j[1]);
    const float middle = 0.5 * (a + c), half_difference = 0.5 * (a - c);
    const float radius = sqrt(half_difference * half_difference + b * b);
    // The better conditioned of the two forms of the eigenvector of [a b; b c].
    const vec2 v = half_difference >= 0.0 ? vec2(half_difference + radius, b) : vec2(b, radius - half_difference);
    const float length2 = dot(v, v);
    Stretches s;
    s.first = length2 > 0.0 ? v * inversesqrt(length2) : vec2(1.0, 0.0);
    s.second = vec2(-s.first.y, s.first.x);
    s.s1 = sqrt(middle + radius);
    s.s2 = sqrt(max(middle - radius, 0.0));
    return s;
}
