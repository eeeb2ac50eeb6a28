#version 450
// SPDX-License-Identifier: MIT
// The slope of the nearest surface, metres along the light per metre across it. It is a hint: whatever is stored, the
// bounds are made for exactly that plane. Steep surfaces get a level plane, whose bound is the depth itself.
#extension GL_GOOGLE_include_directive : require
#include "cascade.glsl"

layout(location = 0) in float along_m;
layout(location = 0) out vec2 slope;

const float STEEPEST = 64.0;

void main() {
    const vec2 s = vec2(dFdx(along_m), dFdy(along_m)) / cascade.texel_m;
    slope = abs(s.x) + abs(s.y) < STEEPEST ? s : vec2(0.0);
}
