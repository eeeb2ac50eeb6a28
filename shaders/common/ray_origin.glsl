// SPDX-License-Identifier: MIT
// Where the shadow ray of a pixel starts (common/ray_offset.glsl).
//
// Includer has common/camera.glsl and common/receiver_normal.glsl and declares: image view_depth,
// receiver_normal; block scene.
#include "common/ray_offset.glsl"

// In the scene's frame, for a pixel that shows a surface with this normal.
vec3 shadow_ray_origin(ivec2 p, vec3 n) {
    const float z = imageLoad(view_depth, p).x;
    const vec3 relative = position(p, z);
    const vec3 in_scene = relative + scene.camera_from_origin;
    return in_scene + n * robust_offset_m(p, z, n, relative, in_scene);
}

vec3 shadow_ray_origin(ivec2 p) { return shadow_ray_origin(p, decode_receiver_normal(imageLoad(receiver_normal, p).xy)); }
