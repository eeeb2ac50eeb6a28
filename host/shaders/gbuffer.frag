#version 450
// SPDX-License-Identifier: MIT
// Normal, motion and albedo of the nearest surface (conventions: host inputs `normal`, `motion`, `albedo`).

layout(set = 1, binding = 0) uniform sampler2D base_color_texture;

layout(location = 0) in vec3 clip_xyw;
layout(location = 1) in vec3 prev_clip_xyw;
layout(location = 2) in vec2 texture_uv;
layout(location = 3) flat in vec3 normal;
layout(location = 4) flat in vec3 base_color;

layout(location = 0) out vec4 out_normal;
layout(location = 1) out vec4 out_motion;
layout(location = 2) out vec4 out_albedo;

// Where the point was behind the previous camera it had no place in the image: any uv outside it says so.
const vec2 off_screen = vec2(16.0);
const float largest_half = 65504.0;

void main() {
    vec2 motion = off_screen;
    if (prev_clip_xyw.z > 0.0) {
        motion = 0.5 * (prev_clip_xyw.xy / prev_clip_xyw.z - clip_xyw.xy / clip_xyw.z);
    }
    const float depth_change = prev_clip_xyw.z - clip_xyw.z;
    out_normal = vec4(normal, 0.0);
    out_motion = vec4(clamp(vec3(motion, depth_change), -largest_half, largest_half), 0.0);
    out_albedo = vec4(texture(base_color_texture, texture_uv).rgb * base_color, 1.0);
}
