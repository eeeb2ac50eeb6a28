// SPDX-License-Identifier: MIT
// What the G-buffer's two stages and its C++ side share: the record of one draw, and the push constants.
struct Draw {
    mat4 clip_from_local;       // camera-relative, without jitter
    mat4 prev_clip_from_local;  // the previous frame's camera and transform
    mat3 world_from_local;      // of winding normals: the cofactor matrix, whose sign follows a mirrored triangle
    vec4 camera_local;          // camera position in the part's frame; w: the transform's determinant, scaled as world_from_local is
    vec4 camera_local_low;      // what rounding took from it; w unused
    vec4 base_color;            // linear
    vec4 metallic_roughness;    // factors; z: 1 where it is seen from its front alone, else 0; w unused
    vec4 emissive;              // factor; w unused
};

layout(push_constant) uniform Constants {
    vec2 jitter_ndc;
    vec2 ndc_per_pixel;  // 2 / size
    // What a pixel sees, camera-relative along the world's axes: ray_0 + x ray_x + y ray_y for its ndc, without jitter, times the view
    // depth; of an orthographic camera that is the point at view depth 0, and the direction is `ahead`.
    vec4 ray_x;  // w: depth_z, where depth = (depth_1 + depth_z * z) / z, orthographic without the division, for a view depth z
    vec4 ray_y;  // w: depth_1
    vec4 ray_0;  // w: 1 of an orthographic camera, 0 of a perspective one
    vec4 ahead;  // w unused
    uint least_alpha;  // of 255; texels below it are not there
} constants;
