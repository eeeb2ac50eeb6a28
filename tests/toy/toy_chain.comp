// SPDX-License-Identifier: MIT
#include "node.glsl"

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(sums)))) return;
    float sum = 0.0;
    if (params.mip_level == 0u) {
        sum = params.scale * texelFetch(value, p, 0).x;
    } else {
        const ivec2 last = imageSize(sums_finer) - 1;
        for (int i = 0; i < 4; ++i) {
            const ivec2 below = 2 * p + ivec2(i & 1, i >> 1);
            if (all(lessThanEqual(below, last))) sum += imageLoad(sums_finer, below).x;
        }
    }
    imageStore(sums, p, vec4(sum));
}
