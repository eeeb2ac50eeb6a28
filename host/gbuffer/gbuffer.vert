#version 450
// SPDX-License-Identifier: MIT
// The clip position, how it has changed since the previous frame, and the triangle's normal turned towards the viewer.
// The normal is the provoking (first) vertex's: the host gives every triangle a first vertex of its own, and so its plane.
#extension GL_GOOGLE_include_directive : require
#include "gbuffer.glsl"

layout(set = 0, binding = 0) uniform Drawn { Draw draw; };

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 winding_normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec4 vertex_color;
layout(location = 4) in vec3 prev_position;  // in the part's frame: another one where vertices move in it

layout(location = 0) out vec3 clip_change;  // x, y, w: previous - current
layout(location = 1) out vec2 texture_uv;
layout(location = 2) flat out vec3 normal;
layout(location = 3) out vec3 base_color;
layout(location = 4) flat out float plane_offset;  // of the triangle's plane: normal . x for x camera-relative, metres
layout(location = 5) flat out uint hidden;         // 1: its back is before the viewer, who sees its front alone

void main() {
    const vec4 clip = draw.clip_from_local * vec4(position, 1.0);
    const vec4 prev = draw.prev_clip_from_local * vec4(prev_position, 1.0);
    clip_change = prev.xyw - clip.xyw;
    texture_uv = uv;
    base_color = draw.base_color.rgb * vertex_color.rgb;
    // The camera lies on one side of the whole triangle's plane; which one is exact to fp32 in the part's own frame,
    // where the raster's own front and back come from positions snapped to a grid.
    const vec3 from_camera = (position - draw.camera_local.xyz) - draw.camera_local_low.xyz;
    const vec3 scaled = draw.world_from_local * winding_normal;
    const float offset = dot(winding_normal, from_camera) * draw.camera_local.w;  // cofactors(M) n . M x = det(M) n . x
    const float turned = (offset > 0.0 ? -1.0 : 1.0) / length(scaled);
    normal = scaled * turned;
    plane_offset = offset * turned;
    hidden = draw.metallic_roughness.z != 0.0 && dot(winding_normal, from_camera) > 0.0 ? 1u : 0u;
    gl_Position = clip + vec4(constants.jitter_ndc * clip.w, 0.0, 0.0);
}
