// SPDX-License-Identifier: MIT
// What each pixel shows, for the next frame (reflections/kept_surface.glsl).
#include "node.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/rounded.glsl"
#include "reflections/kept_surface.glsl"

void for_pixel(ivec2 p) {
    const float z = imageLoad(view_depth, p).x, roughness = HAS_MATERIAL ? texelFetch(material, p, 0).y : 1.0;
    const vec3 n = unpack_direction(imageLoad(octahedral_normal, p).x);
    imageStore(surface_kept, p, uvec4(z > 0.0 ? encode_surface(z, n, roughness) : 0u));
}

void main() { for_each_pixel(); }
