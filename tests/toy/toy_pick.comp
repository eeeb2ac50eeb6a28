// SPDX-License-Identifier: MIT
#include "node.glsl"

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(picked)))) return;
    const int level = p.x % textureQueryLevels(sums);
    const ivec2 size = max(textureSize(sums, 0) >> level, 1);  // lavapipe answers for one lane's level where lanes differ
    imageStore(picked, p, vec4(texelFetch(sums, min(p >> level, size - 1), level).x));
}
