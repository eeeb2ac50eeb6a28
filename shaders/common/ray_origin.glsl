// SPDX-License-Identifier: MIT
// Where the ray of a pixel to a light starts (common/ray_offset.glsl), in the scene's frame.
//
// Includer has common/camera.glsl and common/receiver_normal.glsl and declares: image view_depth,
// receiver_normal; block scene.
#include "common/ray_offset.glsl"

// Before it is known which way it goes.
struct RayStart {
    vec3 off_surface;
    float beyond_edge_m;
};

// For a pixel that shows a surface with this normal.
RayStart ray_start(ivec2 p, vec3 n) {
    const float z = imageLoad(view_depth, p).x;
    const vec3 relative = position(p, z);
    const vec3 in_scene = relative + scene.camera_from_origin;
    return RayStart(in_scene + n * robust_offset_m(p, z, n, relative, in_scene), beyond_edge_m(p, z, n));
}

// `towards`: unit; the axis of the light, not the ray's own direction, so that all rays of a pixel start at one point.
vec3 ray_origin(RayStart start, vec3 n, vec3 towards) {
    return start.off_surface + start.beyond_edge_m * ahead_of_edge(dot(n, towards)) * towards;
}

vec3 ray_origin(ivec2 p, vec3 n, vec3 towards) { return ray_origin(ray_start(p, n), n, towards); }

// `target`: the middle of a light that is near, of which a ray keeps 99 % of the way.
vec3 ray_origin_to(RayStart start, vec3 n, vec3 target) {
    const vec3 way = target - start.off_surface;
    const float per_m = inversesqrt(max(dot(way, way), 1e-30));
    return start.off_surface + min(start.beyond_edge_m * ahead_of_edge(dot(n, way) * per_m) * per_m, 0.01) * way;
}
