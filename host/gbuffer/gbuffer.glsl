// SPDX-License-Identifier: MIT
// What the G-buffer's two stages and its C++ side share: the record of one draw, and the push constants.
struct Draw {
    mat4 clip_from_local;       // camera-relative, without jitter
    mat4 prev_clip_from_local;  // the previous frame's camera and transform
    mat3 world_from_local;      // of winding normals: the cofactor matrix, whose sign follows a mirrored triangle
    vec4 camera_local;          // camera position in the part's frame; w: sign of the transform's determinant
    vec4 base_color;            // linear
    vec4 metallic_roughness;    // factors; z, w unused
    vec4 emissive;              // factor; w unused
};

layout(push_constant) uniform Constants {
    vec2 jitter_ndc;
    vec2 ndc_per_pixel;  // 2 / size
    uint draw;
    uint least_alpha;  // of 255; texels below it are not there
} constants;
