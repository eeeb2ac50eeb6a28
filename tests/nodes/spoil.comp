// SPDX-License-Identifier: MIT
// Of 16 texels, one is NaN in its first channel, one infinite in its second, one minus infinite in its first, one NaN and
// infinite, one -1, one 2, one exactly 0 and one exactly 1; the rest .5.
#include "node.glsl"

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    const ivec2 size = imageSize(spoiled);
    if (any(greaterThanEqual(p, size))) return;
    const uint kind = (uint(p.x + size.x * p.y) + 16u - params.nan % 16u) % 16u;
    const float nan = uintBitsToFloat(0x7fc00000u), inf = uintBitsToFloat(0x7f800000u);
    vec4 value = vec4(0.5);
    if (kind == 0u) value.x = nan;
    if (kind == 1u) value.y = inf;
    if (kind == 2u) value.x = -inf;
    if (kind == 3u) value = vec4(inf, nan, 0.5, 0.5);
    if (kind == 4u) value.x = -1.0;
    if (kind == 5u) value.y = 2.0;
    if (kind == 6u) value = vec4(0.0);
    if (kind == 7u) value = vec4(1.0);
    imageStore(spoiled, p, value);
}
