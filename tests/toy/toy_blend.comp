// SPDX-License-Identifier: MIT
#include "node.glsl"

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(blended)))) return;
    float sum = texelFetch(value, p, 0).x;
    if (HAS_HISTORY && (frame.flags & FRAME_RESET) == 0u) sum += 0.5 * imageLoad(history, p).x;
    imageStore(blended, p, vec4(sum));
}
