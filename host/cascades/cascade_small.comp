#version 450
// SPDX-License-Identifier: MIT
// Sorts a cascade's triangles, one invocation each: out of the map, small, or large. A small one's texels are bounded
// here, into a buffer of ordered integers; for triangles of a few texels that is far cheaper than rasterising a polygon
// about each. Large ones are listed for the draw.
#extension GL_GOOGLE_include_directive : require
#include "cascade.glsl"
#include "cascade_margin.glsl"
#include "cascade_texel.glsl"
#include "cascade_order.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 1) uniform sampler2DArray slopes;
layout(set = 0, binding = 2, std430) buffer Small { uint small_bounds[]; };  // two per texel
layout(set = 0, binding = 3, std430) buffer Large {
    uint vertex_count, instance_count, first_vertex, first_instance;
    uint triangles[];
} large;

const int SMALL_TEXELS = 100;  // of the box about a triangle; see docs/cascades.md

void main() {
    const uint triangle = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    if (triangle >= cascade.triangle_count) return;
    const vec3 a = in_cascade(3u * triangle), b = in_cascade(3u * triangle + 1u), c = in_cascade(3u * triangle + 2u);
    vec2 low, high;
    if (!texel_box(a, b, c, low, high)) return;
    const ivec2 first = ivec2(low), size = ivec2(high - low);
    if (size.x * size.y > SMALL_TEXELS) {
        large.triangles[atomicAdd(large.vertex_count, 15u) / 15u] = triangle;
        return;
    }
    for (int i = 0; i < size.x * size.y; ++i) {
        const ivec2 texel = first + ivec2(i % size.x, i / size.x);
        const vec2 found = bounds_in_texel(a, b, c, texel, texelFetch(slopes, ivec3(texel, cascade.layer), 0).xy);
        const uint at = 2u * (uint(texel.y) * uint(cascade.size) + uint(texel.x));
        if (found.x < NO_SURFACE_M) {
            atomicMin(small_bounds[at], ordered(found.x));
            atomicMin(small_bounds[at + 1u], ordered(found.y));
        }
    }
}
