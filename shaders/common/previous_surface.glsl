// SPDX-License-Identifier: MIT
// Was this surface seen there? The surface point behind a pixel of the previous frame must lie on the receiver's plane,
// within a few pixels' width. A distance to a plane needs no angle-dependent tolerance at grazing views and no absolute
// length. Includer has camera.glsl.

// Camera-relative point, in the *current* camera's terms, that a texel of the previous frame showed at `view_depth`.
// The texel's centre and its depth are three linear equations in the point; Cramer's rule solves them.
vec3 previous_position(ivec2 texel, float view_depth) {
    const mat4 m = transpose(frame.prev_clip_from_rel);  // rows
    const vec2 uv = (vec2(texel) + 0.5) / vec2(frame.prev_size) - frame.prev_jitter;
    const vec2 ndc = 2.0 * uv - 1.0;
    const vec4 x = m[0] - ndc.x * m[3], y = m[1] - ndc.y * m[3];
    // Depth is w of a perspective; see previous_depth() for the other.
    vec4 z = m[3] - vec4(0.0, 0.0, 0.0, view_depth);
    if ((frame.flags & FRAME_ORTHOGRAPHIC) != 0u)
        z = frame.view_from_clip[2].z * m[2] + vec4(0.0, 0.0, 0.0, frame.view_from_clip[3].z + view_depth);
    const vec3 xy = cross(x.xyz, y.xyz), yz = cross(y.xyz, z.xyz), zx = cross(z.xyz, x.xyz);
    return -(x.w * yz + y.w * zx + z.w * xy) / dot(xy, z.xyz);
}

