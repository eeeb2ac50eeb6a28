#version 450
// SPDX-License-Identifier: MIT
// The small triangles' bounds (cascade_small.comp) as what the large ones are blended with.
#extension GL_GOOGLE_include_directive : require
#include "cascade.glsl"
#include "cascade_order.glsl"

layout(set = 0, binding = 1) uniform sampler2DArray slopes;
layout(set = 0, binding = 2, std430) readonly buffer Small { uint small_bounds[]; };

layout(location = 0) out vec4 bounds;

void main() {
    const ivec2 texel = ivec2(gl_FragCoord.xy);
    const uint at = 2u * (uint(texel.y) * uint(cascade.size) + uint(texel.x));
    const uint least = small_bounds[at];
    bounds = least == NONE ? vec4(1e30)
                           : vec4(from_ordered(least), from_ordered(small_bounds[at + 1u]),
                                  texelFetch(slopes, ivec3(texel, cascade.layer), 0).xy);
}
