// SPDX-License-Identifier: MIT
#include "node.glsl"

void main() {
    const uvec2 p = gl_GlobalInvocationID.xy;
    const uvec2 size = uvec2(textureSize(value, 0));
    const uint half_width = (size.x + 1u) / 2u;
    if (all(lessThan(p, (size + 1u) / 2u))) weights[p.y * half_width + p.x] = float(p.x + 1u);
    if (p == uvec2(0)) {
        arguments[1] = 1u;
        arguments[2] = 1u;
    }
    if (any(greaterThanEqual(p, size)) || (p.y & 1u) != 0u) return;
    const uint at = atomicAdd(arguments[3], 1u);
    list[at] = p;
    atomicMax(arguments[0], at / 8u + 1u);
}
