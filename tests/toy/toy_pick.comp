// SPDX-License-Identifier: MIT
#include "node.glsl"

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(picked)))) return;
    const int level = p.x % textureQueryLevels(sums);
    const ivec2 size = textureSize(sums, level);
    imageStore(picked, p, vec4(texelFetch(sums, min(p >> level, size - 1), level).x));
}
