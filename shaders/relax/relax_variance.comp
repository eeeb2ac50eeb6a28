// SPDX-License-Identifier: MIT
// RELAX: the variance that guides its filter. Of the past's moments over 3x3 pixels, or, while it is short, of 5x5 pixels that are
// alike. Published within the filter's first level, which is the same.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/rounded.glsl"
#include "common/same_surface.glsl"
#include "relax/light.glsl"
#include "relax/relax.glsl"
#include "relax/frames.glsl"

const float SHORT = 3.0;
const float GAUSSIAN[2] = float[](0.5, 0.25);

void for_pixel(ivec2 p) {
    const vec4 own = imageLoad(slow, p);
    const Shown here = shown(p);
    if (!(here.z > 0.0)) {
        store_estimated(p, vec4(0.0));
        return;
    }
    const float length_now = decode_frames(imageLoad(frames, p).x);
    const bool few = length_now < SHORT;
    const int reach = few ? 2 : 1;
    float mean = 0.0, squares = 0.0, weights = 0.0;
    for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
            const ivec2 q = p + ivec2(x, y);
            const Shown there = shown(q);
            if (!(there.z > 0.0)) continue;
            const float weight = q == p ? (few ? 1.0 : GAUSSIAN[0] * GAUSSIAN[0])
                                        : few ? likeness(here, there) : GAUSSIAN[abs(x)] * GAUSSIAN[abs(y)];
            const vec4 texel = imageLoad(slow, q);
            mean += weight * luminance(texel.rgb);
            squares += weight * texel.w * texel.w;
            weights += weight;
        }
    mean /= weights;
    const float variance = max(squares / weights - mean * mean, 0.0) * (few ? max(1.0, 4.0 / (length_now + 1.0)) : 1.0);
    store_estimated(p, vec4(own.rgb, sqrt(variance)));
}

void main() { for_each_pixel(); }
