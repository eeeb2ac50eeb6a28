// SPDX-License-Identifier: MIT
// What each pixel shows in one texel (common/surface_texel.glsl): passes that ask many neighbours load one image instead of three.
#include "node.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/rounded.glsl"
#include "common/surface_texel.glsl"

void for_pixel(ivec2 p) {
    const float z = imageLoad(view_depth, p).x, roughness = HAS_MATERIAL ? texelFetch(material, p, 0).y : 1.0;
    const uint normal = imageLoad(octahedral_normal, p).x;
    store_surface(p, uvec4(z > 0.0 ? encode_surface(z, normal, roughness) : uvec2(0u), 0u, 0u));
}

void main() { for_each_pixel(); }
