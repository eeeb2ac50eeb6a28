// SPDX-License-Identifier: MIT
// RELAX, history fix: a past of few frames is blurred with 5x5 others, far apart at first and nearer as it grows.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/rounded.glsl"
#include "common/same_surface.glsl"
#include "relax/relax.glsl"
#include "relax/frames.glsl"

// Published: max(.01, cosine)^8 alone, for any lobe; a mirror's is narrower.
float weight_of(Shown here, Shown there) {
    const float cosine = max(dot(here.n, there.n), 0.01), c2 = cosine * cosine, c4 = c2 * c2;
    return c4 * c4 * likeness(here, there);
}

void for_pixel(ivec2 p) {
    const vec4 own = imageLoad(slow_now, p);
    const float length_now = decode_frames(imageLoad(frames, p).x);
    const Shown here = shown(p);
    // Published without the second: a mirror's image must not be blurred wider than its lobe.
    float stride = round(14.0 / (1.0 + length_now));
    if (LOBE == LOBE_SPECULAR) stride = min(stride, 0.5 * footprint_px(here, imageLoad(fast_now, p).w));
    if (!(here.z > 0.0) || length_now > FIX_FRAMES || stride < 1.0) {
        store_slow_fixed(p, own);
        return;
    }
    vec3 sum = own.rgb;
    float squares = own.w * own.w, weights = 1.0;
    for (int i = 0; i < 25; ++i) {
        if (i == 12) continue;
        const ivec2 q = p + int(stride) * (ivec2(i % 5, i / 5) - 2);
        const Shown there = shown(q);
        const float weight = there.z > 0.0 ? weight_of(here, there) : 0.0;
        if (!(weight > 0.0)) continue;
        const vec4 other = imageLoad(slow_now, q);
        sum += weight * other.rgb;
        squares += weight * other.w * other.w;
        weights += weight;
    }
    store_slow_fixed(p, vec4(sum / weights, sqrt(squares / weights)));
}

void main() { for_each_pixel(); }
