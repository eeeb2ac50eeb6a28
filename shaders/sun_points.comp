// SPDX-License-Identifier: MIT
// The noise repeats every 128 pixels, so a frame has 16 384 sun samples, however large it is. Who reads its neighbours'
// samples finds them here instead of mapping the square to the disc again for each.
#include "node.glsl"
#include "common/sun_point.glsl"

void main() {
    const int i = int(gl_GlobalInvocationID.x);
    const ivec2 pixel = ivec2(i % blue_noise_size, i / blue_noise_size);
    sun_points[i] = packSnorm2x16(sun_point(pixel, frame.frame_index, params.seed));
}
