// SPDX-License-Identifier: MIT
#include "node.glsl"

// A stride that is a prime above the count visits every place once.
void main() {
    const uint count = trace_args[3];
    for (uint i = gl_LocalInvocationIndex; i < count; i += 64u)
        permuted_list[params.stride == 0u ? count - 1u - i : i * params.stride % count] = tile_list[i];
}
