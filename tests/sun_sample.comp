#version 460
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT
// Evaluates shaders/common/sun_sample.glsl on a list for tests/sun_sample_test.cpp.
layout(local_size_x = 64) in;
struct In {
    vec4 to_sun_and_radius, u;
};
struct Out {
    vec4 exact, polar, published;
};
layout(std430, set = 0, binding = 0) readonly buffer Ins { In ins[]; };
layout(std430, set = 0, binding = 1) writeonly buffer Outs { Out outs[]; };
layout(push_constant) uniform Push { uint count; };

#include "../shaders/common/sun_sample.glsl"

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    vec3 to_sun = ins[i].to_sun_and_radius.xyz;
    float radius = ins[i].to_sun_and_radius.w;
    outs[i].exact = vec4(sun_direction(to_sun, radius, ins[i].u.xy), 0);
    outs[i].polar = vec4(sun_direction_through(to_sun, radius, polar_disc(ins[i].u.xy)), 0);
    outs[i].published = vec4(sun_direction_published(to_sun, radius, ins[i].u.xy), 0);
}
