// SPDX-License-Identifier: MIT
// RELAX, history clamping and antilag: the long past is limited to the short one's mean and deviations over 5x5 pixels, in YCoCg;
// where it had to be, both go towards the frame's mean, and a past that differs by more than noise goes towards the frame itself.
#include "node.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/rounded.glsl"
#include "common/surface_texel.glsl"
#include "relax/frames.glsl"
#include "relax/light.glsl"

const float BOX_DEVIATIONS = 2.0;
const float ACCELERATION = 10.0 * 0.3, RESET = 0.5;
const float SPECULAR_ACCELERATION = 0.33 * ACCELERATION, SPECULAR_RESET = 0.5 * RESET;
// Of the second .5 is the published default. A mirror's edge that shows a lamp now and then is darkened by it: 64 frames of `street`
// are worth 230 rays instead of 32, and a lamp that goes off lags no longer.
const float SPATIAL_DEVIATIONS = 4.5, TEMPORAL_DEVIATIONS = 2.0;

vec3 to_ycocg(vec3 c) {
    return vec3(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * c.r - 0.5 * c.b, -0.25 * c.r + 0.5 * c.g - 0.25 * c.b);
}
vec3 to_rgb(vec3 c) { return max(vec3(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z), vec3(0.0)); }

void store(ivec2 p, vec4 of_slow, vec4 of_fast) {
    store_slow(p, of_slow);
    store_fast(p, of_fast);
}

// What 5x5 pixels hold: the short past's mean and deviation, the frame's mean and its luminance's deviation.
struct Around {
    vec3 mean, deviation, frame_mean;
    float frame_deviation;
};

Around look_around(ivec2 p) {
    vec3 sum = vec3(0.0), squares = vec3(0.0), now = vec3(0.0);
    float now_squares = 0.0, count = 0.0;
    for (int i = 0; i < 25; ++i) {
        const ivec2 q = p + ivec2(i % 5, i / 5) - 2;
        if (!inside_frame(q) || !(surface_depth(imageLoad(surface, q).xy) > 0.0)) continue;
        const vec3 c = to_ycocg(imageLoad(fast_now, q).rgb), b = imageLoad(blurred, q).rgb;
        const float light = luminance(b);
        sum += c;
        squares += c * c;
        now += b;
        now_squares += light * light;
        count += 1.0;
    }
    const vec3 mean = sum / count, now_mean = now / count;
    const float light = luminance(now_mean);
    return Around(mean, sqrt(max(squares / count - mean * mean, vec3(0.0))), now_mean, sqrt(max(now_squares / count - light * light, 0.0)));
}

void for_pixel(ivec2 p) {
    vec4 of_slow = imageLoad(slow_fixed, p), of_fast = imageLoad(fast_now, p);
    if (!(surface_depth(imageLoad(surface, p).xy) > 0.0)) {
        store(p, vec4(0.0), vec4(0.0));
        return;
    }
    if (decode_frames(imageLoad(frames, p).x) <= FIX_FRAMES) {
        store(p, of_slow, vec4(of_slow.rgb, of_fast.w));
        return;
    }
    const Around around = look_around(p);
    const vec3 own = to_ycocg(of_fast.rgb), reach = BOX_DEVIATIONS * around.deviation;
    const vec3 before = to_ycocg(of_slow.rgb);
    const vec3 clamped = clamp(before, min(around.mean - reach, own), max(around.mean + reach, own));
    const float light_before = luminance(of_slow.rgb);
    const float gap = abs(luminance(of_fast.rgb) - light_before);

    // How far towards the short past the long one had to go.
    const float moved = clamp(abs(clamped.x - before.x) / max(abs(own.x - before.x), 1e-6), 0.0, 1.0);
    vec3 slow_light = all(equal(clamped, before)) ? of_slow.rgb : to_rgb(clamped);
    // Published in units of radiance; here of what is there, so that an image of another exposure is the same.
    const float go = (LOBE == LOBE_SPECULAR ? SPECULAR_ACCELERATION : ACCELERATION) * moved * gap / max(max(luminance(of_fast.rgb), light_before), 1e-6);
    slow_light = mix(slow_light, around.frame_mean, min(go, 1.0));
    of_fast.rgb = mix(of_fast.rgb, around.frame_mean, min(go, 1.0));

    const vec3 now = imageLoad(blurred, p).rgb;
    const float light = luminance(slow_light), light_now = luminance(now);
    const float temporal = sqrt(max(of_slow.w * of_slow.w - light_before * light_before, 0.0));
    const float beyond = abs(light - light_now) - SPATIAL_DEVIATIONS * around.frame_deviation - TEMPORAL_DEVIATIONS * temporal;
    const float reset = (LOBE == LOBE_SPECULAR ? SPECULAR_RESET : RESET) * max(beyond, 0.0) / (max(light, light_now) + 1e-6);
    slow_light = mix(slow_light, now, min(reset, 1.0));
    of_fast.rgb = mix(of_fast.rgb, now, min(reset, 1.0));

    const float light_after = luminance(slow_light);
    const float square = of_slow.w * of_slow.w + light_after * light_after - light_before * light_before;
    store(p, vec4(slow_light, sqrt(max(square, 0.0))), of_fast);
}

void main() { for_each_pixel(); }
