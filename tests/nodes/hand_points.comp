// SPDX-License-Identifier: MIT
// Row by row; images of the host are only sampled, and the reader of these loads them.
#include "node.glsl"
#include "common/pixels.glsl"

void for_pixel(ivec2 p) { imageStore(sun_points, p, uvec4(given_points[uint(p.y) * frame.size.x + uint(p.x)], 0u, 0u, 0u)); }

void main() { for_each_pixel(); }
