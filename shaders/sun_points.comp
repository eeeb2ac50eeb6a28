// SPDX-License-Identifier: MIT
// The points of the sun that this frame's rays go to. Who reads its neighbours' points finds them here instead of asking
// sine and cosine again for each: gather asks for up to 81 of them per pixel.
#include "node.glsl"
#include "common/pixels.glsl"
#include "common/sun_point.glsl"

void for_pixel(ivec2 p) {
    imageStore(sun_points, p, uvec4(pack_point(sun_point(p, frame.frame_index, params.seed)), 0u, 0u, 0u));
}

void main() { for_each_pixel(); }
