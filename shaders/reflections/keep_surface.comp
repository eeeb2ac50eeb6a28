// SPDX-License-Identifier: MIT
// What each pixel shows, for the next frame (reflections/kept_surface.glsl).
#include "node.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/rounded.glsl"
#include "common/surface_texel.glsl"
#include "reflections/kept_surface.glsl"

void for_pixel(ivec2 p) {
    const uvec2 shown = imageLoad(surface, p).xy;
    const float z = surface_depth(shown);
    store_surface_kept(p, uvec4(z > 0.0 ? encode_kept(z, surface_normal(shown), surface_roughness(shown)) : 0u));
}

void main() { for_each_pixel(); }
