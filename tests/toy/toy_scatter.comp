// SPDX-License-Identifier: MIT
#include "node.glsl"

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= arguments[3]) return;
    const ivec2 p = ivec2(list[i]);
    const int half_width = (textureSize(value, 0).x + 1) / 2;
    const float weight = texelFetch(weights, (p.y / 2) * half_width + p.x / 2).x;
    imageStore(scattered, p, vec4(weight + texelFetch(value, p, 0).x));
}
