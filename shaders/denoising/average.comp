// SPDX-License-Identifier: MIT
// Where nothing moves and no jitter shifts the pixels, each frame samples the same visibility anew, and the plain mean of them is
// exact. A frame that is jittered otherwise than the last, or of another size, shows other points of the surface: it starts anew, as after a reset.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/pixels.glsl"

const float STEPS = 4194303.0;  // 2^22 - 1
const uint MOST_FRAMES = 1023u;

void for_pixel(ivec2 p) {
    const uint before = imageLoad(mean_prev, p).x;
    const bool anew = !pixels_have_pasts() || frame.jitter != frame.prev_jitter;
    const uint frames = anew ? 1u : min((before >> 22) + 1u, MOST_FRAMES);
    const float fresh_value = texelFetch(fresh, p, 0).x;
    const float old = float(before & 0x3fffffu) / STEPS;
    const float now = frames == 1u ? fresh_value : old + (fresh_value - old) / float(frames);
    store_mean(p, uvec4(uint(now * STEPS + 0.5) | frames << 22, 0u, 0u, 0u));
    store_visibility(p, vec4(now));
}

void main() { for_each_pixel(); }
