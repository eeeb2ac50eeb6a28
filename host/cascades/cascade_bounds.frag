#version 450
// SPDX-License-Identifier: MIT
// One large triangle's bounds in one texel. Blending keeps the minimum of all triangles; the slope goes along unchanged,
// since all of them write the same.
#extension GL_GOOGLE_include_directive : require
#include "cascade.glsl"
#include "cascade_margin.glsl"
#include "cascade_texel.glsl"

layout(set = 0, binding = 1) uniform sampler2DArray slopes;

layout(location = 0) flat in vec3 a;
layout(location = 1) flat in vec3 b;
layout(location = 2) flat in vec3 c;
layout(location = 0) out vec4 bounds;  // least depth, the plane's depth at the centre (metres), its slope

void main() {
    const ivec2 texel = ivec2(gl_FragCoord.xy);
    const vec2 slope = texelFetch(slopes, ivec3(texel, cascade.layer), 0).xy;
    const vec2 found = bounds_in_texel(a, b, c, texel, slope);
    if (!(found.x < NO_SURFACE_M)) discard;
    bounds = vec4(found, slope);
}
