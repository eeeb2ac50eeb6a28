// SPDX-License-Identifier: MIT
#include "node.glsl"

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(doubled)))) return;
    imageStore(doubled, p, 2.0 * imageLoad(doubled, p));
}
