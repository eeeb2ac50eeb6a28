// SPDX-License-Identifier: MIT
// SIGMA, last pass: the past, clamped to what 5x5 pixels of this frame allow, and mixed in by how long the surface has been seen.
#include "node.glsl"
#include "common/bilinear.glsl"
#include "common/camera.glsl"
#include "common/corners.glsl"
#include "common/disc_taps.glsl"
#include "common/pixels.glsl"
#include "sigma/sigma.glsl"
#include "sigma/tile_value.glsl"

const float MOST_FRAMES = 5.0, LENGTH_CAP = 7.0;
const float SHARPNESS = 0.5;

// A word of the past: a view depth without its three lowest bits, in which there is the number of frames.
uint packed_past(float z, float frames) { return floatBitsToUint(z) & ~7u | uint(min(frames, LENGTH_CAP) + 0.5); }
float past_depth(uint word) { return uintBitsToFloat(word & ~7u); }
float past_frames(uint word) { return float(word & 7u); }

vec4 shadow_at(ivec2 q) {
    if (HAS_COLOURED_SHADOW) return decoded(imageLoad(coloured_shadow, q));
    return decoded(vec4(imageLoad(shadow, q).x));
}

vec4 stable_before(ivec2 q) {
    if (HAS_COLOURED_HISTORY) return imageLoad(coloured_history, q);
    return vec4(imageLoad(history, q).x);
}
#define HISTORY(q) stable_before(q)
BILINEAR(vec4, history_between, HISTORY)
vec4 history_tap(vec2 texel) { return history_between(texel, ivec2(frame.prev_size)); }

// Catmull-Rom over twelve texels by five bilinear taps: the four corners, which weigh least, are left out.
vec4 sharp_history(vec2 texel) {
    const vec2 base = floor(texel - 0.5) + 0.5, f = texel - base;
    const vec2 w0 = f * (-SHARPNESS + f * (2.0 * SHARPNESS - SHARPNESS * f));
    const vec2 w1 = 1.0 + f * f * (-(3.0 - SHARPNESS) + (2.0 - SHARPNESS) * f);
    const vec2 w2 = f * (SHARPNESS + f * ((3.0 - 2.0 * SHARPNESS) - (2.0 - SHARPNESS) * f));
    const vec2 w3 = f * f * (-SHARPNESS + SHARPNESS * f);
    const vec2 w12 = w1 + w2, middle = base + w2 / w12;
    const vec4 side = vec4(w0.x * w12.y, w3.x * w12.y, w12.x * w0.y, w12.x * w3.y);
    const float centre = w12.x * w12.y;
    const vec4 sum = centre * history_tap(middle) + side.x * history_tap(vec2(base.x - 1.0, middle.y)) +
                      side.y * history_tap(vec2(base.x + 2.0, middle.y)) + side.z * history_tap(vec2(middle.x, base.y - 1.0)) +
                      side.w * history_tap(vec2(middle.x, base.y + 2.0));
    return sum / (centre + side.x + side.y + side.z + side.w);
}

struct Past {
    vec4 shadow;
    float frames;  // 0: none
};

// Only those of the four nearest texels count that saw the surface's depth, which is taken for static.
Past past_of(ivec2 p, float z) {
    const Reprojection there = reproject(p, texelFetch(motion, p, 0).xy);
    if ((frame.flags & FRAME_RESET) != 0u || !there.on_screen) return Past(vec4(0.0), 0.0);
    const float expected = previous_depth(position(p, z)), tolerance = PLANE_SENSITIVITY * frustum_m(z) - 1e-6;
    const vec2 texel = there.uv * vec2(frame.prev_size), f = fract(texel - 0.5);
    const ivec2 base = ivec2(floor(texel - 0.5));
    float seen = 0.0, frames = 0.0;
    vec4 weights;
    bool all_seen = true;
    for (int i = 0; i < 4; ++i) {
        const ivec2 q = base + corner(i);
        const bool inside = all(greaterThanEqual(q, ivec2(0))) && all(lessThan(q, ivec2(frame.prev_size)));
        const uint word = inside ? imageLoad(past_prev, q).x : 0u;
        const bool valid = inside && abs(past_depth(word) - expected) <= tolerance;
        weights[i] = valid ? bilinear_share(i, f) : 0.0;
        all_seen = all_seen && valid;
        seen += weights[i];
        frames += weights[i] * past_frames(word);
    }
    if (seen < 1e-4) return Past(vec4(0.0), 0.0);
    vec4 root = vec4(0.0);
    if (all_seen) root = sharp_history(texel);
    for (int i = 0; i < 4 && !all_seen; ++i)
        if (weights[i] > 0.0) root += weights[i] / seen * stable_before(base + corner(i));
    return Past(decoded(clamp(root, 0.0, 1.0)), frames / seen);
}

// Mean and deviation of the shadow over 5x5 pixels.
void moments(ivec2 p, float own, out vec4 mean, out vec4 deviation) {
    vec4 sum = vec4(0.0), squares = vec4(0.0);
    float weights = 0.0;
    for (int y = -2; y <= 2; ++y)
        for (int x = -2; x <= 2; ++x) {
            const ivec2 q = p + ivec2(x, y);
            if (!inside_frame(q) || !(imageLoad(view_depth, q).x > 0.0) || !of_a_kind(imageLoad(penumbra, q).x, own)) continue;
            const vec4 v = shadow_at(q);
            const float weight = disc_gaussian(0.5 * length(vec2(x, y)));
            sum += weight * v;
            squares += weight * (v * v);
            weights += weight;
        }
    mean = sum / weights;
    deviation = sqrt(abs(squares / weights - mean * mean));
}

// The history keeps the root in eight bits; the visibility is what they say, and so is the colour.
void write(ivec2 p, float z, vec4 shadowed, float frames) {
    const vec4 root = floor(255.0 * sqrt(clamp(shadowed, 0.0, 1.0)) + 0.5) / 255.0;
    store_stable(p, root);
    store_visibility(p, vec4(decoded(root).x));
#if HAS_TRANSMITTANCE
    store_transmittance(p, vec4(decoded(root).yzw, 1.0));
#endif
    store_past(p, uvec4(packed_past(z, frames)));
}

void for_pixel(ivec2 p) {
    const float z = imageLoad(view_depth, p).x;
    if (!(z > 0.0)) {
        write(p, 0.0, vec4(1.0), 0.0);
        return;
    }
    const float own = imageLoad(penumbra, p).x;
    const vec4 current = shadow_at(p);
    if (own == 0.0 || tile_value(p) == 0.0) {
        write(p, z, current, LENGTH_CAP);  // sure of itself; its neighbours may go on from it
        return;
    }
    Past before = past_of(p, z);
    vec4 mean, deviation;
    moments(p, own, mean, deviation);
    const vec4 reach = deviation * mix(3.0, 1.0, 1.0 / (1.0 + before.frames));
    vec4 clamped = clamp(before.shadow, mean - reach, mean + reach);
    const float agreement = clamp(1.0 - sqrt(abs(clamped.x - before.shadow.x)), 0.0, 1.0);
    before.frames *= agreement;
    const float weight = before.frames / (1.0 + before.frames);
    clamped = mix(clamped, before.shadow, 0.6 * weight * agreement);
    write(p, z, mix(current, clamped, min(MOST_FRAMES / (1.0 + MOST_FRAMES), weight)), before.frames + 1.0);
}

void main() { for_each_pixel(); }
