// SPDX-License-Identifier: MIT
#include "node.glsl"

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(sum)))) return;
    imageStore(sum, p, vec4(texelFetch(value, p, 0).x + (HAS_BEFORE ? texelFetch(before, p, 0).x : 0.0)));
}
