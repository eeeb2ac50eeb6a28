// SPDX-License-Identifier: MIT
// Each resource has its bad texels at both ends. The first level's dispatch does all that is no mip chain.
#include "node.glsl"

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy), size = imageSize(chain);
    const float nan = uintBitsToFloat(0x7fc00000u), inf = uintBitsToFloat(0x7f800000u);
    if (all(lessThan(p, size))) {
        const bool last = p == size - 1;
        imageStore(chain, p, vec4(p == ivec2(0) ? nan : last ? inf : 1.0));  // one texel is all of the last level
    }
    if (params.mip_level != 0u || p.x != 0) return;
    const int lanes = size.y, lane = p.y;
    if (lane >= lanes) return;
    const ivec3 slices = imageSize(sliced);
    for (int i = lane; i < slices.x * slices.y * slices.z; i += lanes) {
        const ivec3 at = ivec3(i % slices.x, i / slices.x % slices.y, i / (slices.x * slices.y));
        imageStore(sliced, at, vec4(all(equal(at, ivec3(slices.xy - 1, at.z))) ? nan : 0.0));
    }
    for (int i = lane; i < 5003; i += lanes) numbers[i] = i == 0 ? 1.5 : i == 5002 ? -inf : i == 4096 ? nan : 1.0;
    for (int i = lane; i < 77; i += lanes)
        points[i] = i == 76 ? vec4(0.0, -1.0, 0.0, 0.0) : i == 0 ? vec4(0.0, 1.0, 0.0, nan) : vec4(-9.0, 0.0, -9.0, -9.0);
    const int texels = int(frame.size.x) * ((int(frame.size.y) + 6) / 7);
    for (int i = lane; i < texels; i += lanes)
        row[i] = packHalf2x16(i == texels - 1 ? vec2(-1.0, inf) : i == 0 ? vec2(0.0, 0.5) : vec2(-1.0, 0.0));
    for (int i = lane; i < 9; i += lanes) words[i] = 0x7fc00000u;
    if (lane == 0) partial[0] = 1.0;
}
