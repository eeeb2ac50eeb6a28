// SPDX-License-Identifier: MIT
// The frame block: the graph's only built-in uniform block, std140, shared by C++ (frame_block.h supplies the vector
// types) and GLSL (the generated node.glsl includes it). Camera-relative; the host makes it in double precision.
struct FrameBlock {
    mat4 clip_from_view;      // unjittered
    mat4 view_from_clip;      // unjittered
    mat3 world_from_view;     // rotation only: camera-relative positions in world axes
    mat4 prev_clip_from_rel;  // current camera-relative metres -> previous clip (previous projection)
    vec3 camera_delta;        // previous - current camera position, metres
    float near_m;             // depth = near_m / view_depth where the camera is perspective(); no node that ships reads it
    vec2 jitter;              // uv
    vec2 prev_jitter;         // uv
    uvec2 size;               // pixels
    uvec2 prev_size;          // pixels
    float pixel_angle;        // metres that a pixel spans along its longer side, per metre of view depth; orthographic: metres
    float dt_s;               // seconds since the previous recorded frame
    uint frame_index;
    uint flags;               // FRAME_RESET | FRAME_ORTHOGRAPHIC | FRAME_DEPTH_AT_CENTRES
    float snap_px;            // how far beside a pixel's centre, along either axis, its depth may have been taken
    float grid_px;            // and how far past the edge of what it shows the centre may lie
    vec2 prev_depth;          // of an orthographic view: previous view depth = -(x * previous clip z + y)
};
