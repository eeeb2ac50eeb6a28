// SPDX-License-Identifier: MIT
// Which texels of the previous frame showed the surface that a pixel shows now.
//
// Includer has camera.glsl and view_rays.glsl.

const float SAME_FACE = 0.9;  // cosine, as near as 10 bits are to a unit vector: beyond a crease the sun stands differently

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
        z = frame.prev_depth.x * m[2] + vec4(0.0, 0.0, 0.0, frame.prev_depth.y + view_depth);
    const vec3 xy = cross(x.xyz, y.xyz), yz = cross(y.xyz, z.xyz), zx = cross(z.xyz, x.xyz);
    return -(x.w * yz + y.w * zx + z.w * xy) / dot(xy, z.xyz);
}

// What the previous frame's texels showed, from its first one on, along `axes`: previous_position() is linear in a texel's
// place and depth. Taken over the whole image, differences do not round away.
ViewRays previous_rays(mat3 axes) {
    const ivec2 size = ivec2(frame.prev_size);
    const ivec2 right = ivec2(size.x, 0), below = ivec2(0, size.y);
    const vec3 o = axes * previous_position(ivec2(0), 0.0), r = axes * previous_position(ivec2(0), 1.0) - o;
    const vec3 right_o = axes * previous_position(right, 0.0), right_r = axes * previous_position(right, 1.0) - right_o;
    const vec3 below_o = axes * previous_position(below, 0.0), below_r = axes * previous_position(below, 1.0) - below_o;
    const vec2 by_size = 1.0 / vec2(size);
    return ViewRays(o, (right_o - o) * by_size.x, (below_o - o) * by_size.y, r, (right_r - r) * by_size.x,
                    (below_r - r) * by_size.y);
}

// What moves by itself was on another plane, through the point that the motion names: `named_depth` there, at `place` of that frame's texels.
// It is that one's from now on, where the texel `around` it lies nearer to it. A comparison that a NaN fails.
void follow(inout OffPlane plane, vec2 place, float named_depth, ivec2 around, float view_depth) {
    const vec2 middle = place + (frame.prev_jitter - frame.jitter) * vec2(frame.prev_size);
    const float moved_m = metres_off(plane, middle, named_depth), off_m = metres_off(plane, vec2(around), view_depth);
    if (abs(off_m - moved_m) < abs(off_m)) plane.o -= moved_m;
}
