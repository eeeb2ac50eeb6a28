// SPDX-License-Identifier: MIT
#include "node.glsl"
#include "common/pixels.glsl"

void for_pixel(ivec2 p) { imageStore(copied, p, texelFetch(numbers, p, 0)); }

void main() { for_each_pixel(); }
