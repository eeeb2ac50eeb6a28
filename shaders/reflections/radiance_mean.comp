// SPDX-License-Identifier: MIT
// The quotient of radiance_reference's sums: 0 where no surface is.
#include "node.glsl"
#include "common/finite.glsl"
#include "common/pixels.glsl"

void for_pixel(ivec2 p) {
    const vec4 sum = imageLoad(weighted_sum, p);
    const vec3 signal = sum.w > 0.0 ? storable(sum.rgb / sum.w) : vec3(0.0);
    store_mean(p, vec4(signal, 1.0));
}

void main() { for_each_pixel(); }
