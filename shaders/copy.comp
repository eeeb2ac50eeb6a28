// SPDX-License-Identifier: MIT
// An image as it is, texel by texel: how the graph keeps the previous value of a host image ("history": "copy").
#include "node.glsl"

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(p, imageSize(copied)))) imageStore(copied, p, texelFetch(source, p, 0));
}
