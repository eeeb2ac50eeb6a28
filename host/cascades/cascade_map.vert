#version 450
// SPDX-License-Identifier: MIT
// An ordinary shadow map: the nearest surface at each texel's centre.
#extension GL_GOOGLE_include_directive : require
#include "cascade.glsl"

layout(location = 0) out float along_m;

void main() {
    const vec3 p = in_cascade(uint(gl_VertexIndex));
    along_m = p.z;
    gl_Position = clip_position(p.xy, p.z);
}
