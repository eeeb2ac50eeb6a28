// SPDX-License-Identifier: MIT
// Pixels, depths and positions: the only place that knows where a pixel's centre is, what a depth means and where the
// jitter goes. Positions are camera-relative metres along the world's axes; nothing here sees an absolute position.

vec2 pixel_uv(ivec2 p) { return (vec2(p) + 0.5) / vec2(frame.size); }

// View-axis depth in metres; 0 for sky and for whatever is not a depth. Written as positive tests, which a NaN fails.
// Both depth conventions share it: the clear value is 0 in one and 1 in the other, and the matrix knows the rest.
float linear_depth(float depth) {
    const mat4 m = frame.view_from_clip;
    const float z = -(m[2].z * depth + m[3].z) / (m[2].w * depth + m[3].w);
    return depth > 0.0 && depth < 1.0 && z > 0.0 && z < 1e30 ? z : 0.0;
}

// The point that the unjittered camera sees at `uv`, `view_depth` metres in front of it.
vec3 position_at(vec2 uv, float view_depth) {
    const mat4 m = frame.clip_from_view;
    const vec2 ndc = 2.0 * uv - 1.0;
    const vec2 scale = vec2(m[0].x, m[1].y);
    const bool orthographic = (frame.flags & FRAME_ORTHOGRAPHIC) != 0u;
    const vec2 xy = orthographic ? (ndc - m[3].xy) / scale : view_depth * (ndc + m[2].xy) / scale;
    return frame.world_from_view * vec3(xy, -view_depth);
}

// The surface point behind a pixel. The depth buffer was rasterised with jitter, so the ray is that of uv - jitter.
vec3 position(ivec2 p, float view_depth) { return position_at(pixel_uv(p) - frame.jitter, view_depth); }

// Unit vector from the surface at a pixel towards the camera.
vec3 to_viewer(ivec2 p) {
    if ((frame.flags & FRAME_ORTHOGRAPHIC) != 0u) return frame.world_from_view[2];
    return -normalize(position(p, 1.0));
}

// Of the ray through a pixel, away from the camera: the sine of its angle with the horizon, positive upwards.
float view_rise(ivec2 p) {
    const mat4 m = frame.clip_from_view;
    const vec2 slope = (2.0 * (pixel_uv(p) - frame.jitter) - 1.0 + m[2].xy) / vec2(m[0].x, m[1].y);
    const vec2 xy = (frame.flags & FRAME_ORTHOGRAPHIC) != 0u ? vec2(0.0) : slope;
    const vec3 up = vec3(frame.world_from_view[0].y, frame.world_from_view[1].y, frame.world_from_view[2].y);
    return (dot(up.xy, xy) - up.z) * inversesqrt(dot(xy, xy) + 1.0);
}

// Metres along the view axis by which rounding moves a depth kept in 32 bits: 2^-24 of the depth over its slope. That is
// 2^-24 of the view depth for reverse Z; standard Z spends its digits near 1 and loses z^2 / near.
float depth_rounding_m(float view_depth) {
    const mat4 m = frame.clip_from_view;
    const bool orthographic = (frame.flags & FRAME_ORTHOGRAPHIC) != 0u;
    const float depth = orthographic ? m[3].z - m[2].z * view_depth : m[3].z / view_depth - m[2].z;
    const float slope = orthographic ? abs(m[2].z) : abs(m[3].z) / (view_depth * view_depth);
    return 5.9604645e-8 * depth / slope;
}

// Metres that a pixel spans at a view depth, across the view axis.
float pixel_span_m(float view_depth) {
    return frame.pixel_angle * ((frame.flags & FRAME_ORTHOGRAPHIC) != 0u ? 1.0 : view_depth);
}

// Height or width of the view at a depth, whichever is less, in metres.
float frustum_m(float view_depth) { return float(min(frame.size.x, frame.size.y)) * pixel_span_m(view_depth); }

// View-axis depth that a static point had in the previous frame; not positive where it was behind the camera.
// w is the view depth of a perspective; an orthographic camera has none, so its z is undone.
float previous_depth(vec3 relative_position) {
    const vec4 clip = frame.prev_clip_from_rel * vec4(relative_position, 1.0);
    if ((frame.flags & FRAME_ORTHOGRAPHIC) == 0u) return clip.w;
    return -(frame.prev_depth.x * clip.z + frame.prev_depth.y);
}

// Where a pixel's surface was in the previous frame. NaN and infinite motion fail the test and give "off screen".
struct Reprojection {
    vec2 uv;         // previous uv; the pixel's own where `on_screen` is false and the motion is not a number
    bool on_screen;  // strictly inside the previous image
};

Reprojection reproject(ivec2 p, vec2 motion) {
    const vec2 here = pixel_uv(p);
    const vec2 there = here + motion;
    const bool finite = all(lessThan(abs(there), vec2(1e6)));
    return Reprojection(finite ? there : here,
                        finite && all(greaterThan(there, vec2(0.0))) && all(lessThan(there, vec2(1.0))));
}

// The previous frame's texel that contains `uv` (inside the image).
ivec2 previous_texel(vec2 uv) { return min(ivec2(uv * vec2(frame.prev_size)), ivec2(frame.prev_size) - 1); }

// Where nothing moves, a pixel's past is its own: a frame of another size than the last has none.
bool pixels_have_pasts() { return (frame.flags & FRAME_RESET) == 0u && frame.size == frame.prev_size; }
