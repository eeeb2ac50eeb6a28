// SPDX-License-Identifier: MIT
#include "node.glsl"

void main() {
    const uint count = trace_args[3];
    for (uint i = gl_LocalInvocationIndex; i < count; i += 64u) reversed_list[count - 1u - i] = tile_list[i];
}
