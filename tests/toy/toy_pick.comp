// SPDX-License-Identifier: MIT
#include "node.glsl"

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(picked)))) return;
    const int level = p.x % textureQueryLevels(sums);
    const ivec2 size = max(textureSize(sums, 0) >> level, 1);  // lavapipe answers for one lane's level where lanes differ
    const ivec2 texel = min(p >> level, size - 1);
    const vec2 uv = (vec2(texel) + 0.5) / vec2(size);
    const bool by_sampler = (p.y & 1) != 0;
    imageStore(picked, p, by_sampler ? textureLod(sums, uv, float(level)) : texelFetch(sums, texel, level));
}
