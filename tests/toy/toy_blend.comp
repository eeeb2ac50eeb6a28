// SPDX-License-Identifier: MIT
#include "node.glsl"

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(blended)))) return;
    float sum = texelFetch(value, p, 0).x;
    const bool was_there = (frame.flags & FRAME_RESET) == 0u && all(lessThan(p, ivec2(frame.prev_size)));
    if (HAS_HISTORY && was_there) sum += 0.5 * imageLoad(history, p).x;
    imageStore(blended, p, vec4(sum));
}
