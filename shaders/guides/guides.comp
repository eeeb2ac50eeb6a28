// SPDX-License-Identifier: MIT
// Depth and normal of the host in the small formats that later passes read: linear view depth (0 = sky), a 10-bit normal
// that is zero where nothing receives a shadow, and the exact one for rays. Bad input ends here: a NaN depth becomes sky, a normal
// without a direction faces the camera. A host that has no geometric normals leaves the port unbound and gets those of
// the surface that the depth buffer shows.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#if HAS_RECEIVER_NORMAL || HAS_OCTAHEDRAL_NORMAL
#include "common/receiver_normal.glsl"
#endif

float depth_at(ivec2 p) { return inside_frame(p) ? linear_depth(texelFetch(depth, p, 0).x) : 0.0; }

vec3 given_normal(ivec2 p) {
    vec3 n = texelFetch(normal, p, 0).xyz;
#ifdef FORMAT_NORMAL_RGB10A2
    const bool unorm = true;
#else
    const bool unorm = NORMAL_ENCODING == NORMAL_ENCODING_UNORM;
#endif
    if (unorm) n = 2.0 * n - 1.0;
    const float length2 = dot(n, n);
    return length2 > 1e-4 && length2 < 1e4 ? n * inversesqrt(length2) : frame.world_from_view[2];
}

// Along one axis, the step to the neighbour whose depth is nearer: the other one may lie across an edge.
vec3 tangent(ivec2 p, ivec2 axis, float z) {
    const float before = depth_at(p - axis), after = depth_at(p + axis);
    const bool forward = after > 0.0 && (before <= 0.0 || abs(after - z) <= abs(z - before));
    if (forward) return position(p + axis, after) - position(p, z);
    return before > 0.0 ? position(p, z) - position(p - axis, before) : vec3(0.0);
}

vec3 normal_of_depth(ivec2 p, float z) {
    const vec3 viewer = to_viewer(p);
    const vec3 n = cross(tangent(p, ivec2(1, 0), z), tangent(p, ivec2(0, 1), z));
    const float length2 = dot(n, n);
    if (!(length2 > 0.0 && length2 < 1e30)) return viewer;
    return n * inversesqrt(length2) * (dot(n, viewer) < 0.0 ? -1.0 : 1.0);
}

vec3 surface_normal(ivec2 p, float z) {
    if (HAS_NORMAL) return given_normal(p);
    return normal_of_depth(p, z);
}

void for_pixel(ivec2 p) {
    const float z = depth_at(p);
    store_view_depth(p, vec4(z));
    const bool receiver = z > 0.0;
    const vec3 n = receiver ? surface_normal(p, z) : vec3(0.0, 0.0, 1.0);
#if HAS_GUIDE_NORMAL
    store_guide_normal(p, receiver ? encode_normal(n) : vec4(0.0));
#endif
#if HAS_RECEIVER_NORMAL
    store_receiver_normal(p, vec4(encode_receiver_normal(n), 0.0, 0.0));
#endif
#if HAS_OCTAHEDRAL_NORMAL
    store_octahedral_normal(p, uvec4(pack_direction(n)));
#endif
}

void main() { for_each_pixel(); }
