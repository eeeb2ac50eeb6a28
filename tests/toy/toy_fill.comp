// SPDX-License-Identifier: MIT
#include "node.glsl"

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    const ivec2 size = ivec2(frame.size);
    if (any(greaterThanEqual(p, size))) return;
    imageStore(value, p, vec4(params.scale * float(p.x + size.x * p.y) + float(frame.frame_index) + float(BIAS)));
    count_pixels(1u);
}
