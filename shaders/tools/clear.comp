// SPDX-License-Identifier: MIT
// An image of one value: the visibility of scenes in which nothing casts, or whose sun has set.
#include "node.glsl"
#include "common/pixels.glsl"

void for_pixel(ivec2 p) { store_cleared(p, vec4(vec3(params.value), 1.0)); }

void main() { for_each_pixel(); }
