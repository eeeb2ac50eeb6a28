// SPDX-License-Identifier: MIT
#include "node.glsl"

void main() {
    tally[0] += 1u;
    tally[1] = frame.frame_index;
    imageStore(trail, ivec2(frame.frame_index, 0), vec4(frame.frame_index + 1u));
}
