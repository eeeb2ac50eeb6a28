// SPDX-License-Identifier: MIT
// Each pixel's past receives what was gathered, weighted by how far it can be believed: the drift between the two, averaged
// over 5x5 similar pixels and over time, less what noise alone would show, is the past's bias; with 1 / frames it is its error
// in units of the gather's, and the better of the two pasts wins. Nothing is clamped beyond this.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/round_store.glsl"
#include "common/rounded.glsl"
#include "common/dithered.glsl"
#include "reflections/radiance_word.glsl"
#include "reflections/gathered_texel.glsl"
#include "reflections/past_texel.glsl"
#include "reflections/drift_texel.glsl"
#include "reflections/past_places.glsl"
#include "reflections/same_surface.glsl"

const float MOST_FRAMES = 63.0, SIGMAS = 3.0, TERM_SIGMAS = 4.0;
const float DRIFT_SHARE = 0.4;  // of the new value in the running mean
// The same of the variance. Brightness that comes rarely is noise that its own frame alone shows: forgotten soon, what it left in a
// past looks like a bias and is cast out, and the image is too dark (docs/reflections.md#bias).
const float VARIANCE_SHARE = 0.3;
const int FAR_STEP = 5;  // px between taps of far_drift(): a gather's window, so that no two share a ray
const float KERNEL[3] = float[](6.0, 4.0, 1.0);

Gathered gathered_at(ivec2 p) { return decode_gathered(texelFetch(gathered, p, 0).xy); }

// Means over similar pixels.
struct Around {
    float variance, samples, spread;
};

// Weights of the 25 pixels around, 0 where another surface is.
void window(ivec2 p, Shown here, out float weights[25]) {
    for (int i = 0; i < 25; ++i) {
        const ivec2 o = ivec2(i % 5, i / 5) - 2;
        weights[i] = o == ivec2(0) || same_surface(here, shown(p + o)) ? KERNEL[abs(o.x)] * KERNEL[abs(o.y)] : 0.0;
    }
}

Around look_around(ivec2 p, float weights[25]) {
    float sum = 0.0, variance = 0.0, samples = 0.0, squares = 0.0;
    vec3 mean = vec3(0.0);
    for (int i = 0; i < 25; ++i) {
        if (weights[i] == 0.0) continue;
        const ivec2 q = p + ivec2(i % 5, i / 5) - 2;
        const Gathered g = gathered_at(q);
        sum += weights[i];
        variance += weights[i] * g.deviation * g.deviation;
        samples += weights[i] * g.samples;
        mean += weights[i] * g.radiance;
        squares += weights[i] * dot(g.radiance, g.radiance);
    }
    mean /= sum;
    return Around(variance / sum, samples / sum, max(squares / sum - dot(mean, mean), 0.0));
}

// What a past would leave.
struct Candidate {
    vec3 history, drift;
    float frames, worth, variance_mean;  // worth: N', 0 without a past
};

// A drift is of 2x2 pixels.
vec4 carried_drift(ivec2 then) {
    const uvec2 words = texelFetch(drift_prev, clamp(then, ivec2(0), ivec2(frame.prev_size) - 1) / 2, 0).xy;
    return vec4(decode_drift(words.x), decode_deviations(words.y).x);
}

vec4 past(bool image_past, ivec2 q) {
    const vec2 bytes = texelFetch(past_frames, q, 0).xy;
    const Past past = decode_past(image_past ? texelFetch(past_image, q, 0).x : texelFetch(past_surface, q, 0).x,
                                  texel_byte(image_past ? bytes.y : bytes.x));
    return vec4(past.radiance, past.frames);
}

ivec2 far_tap(int i) { return FAR_STEP * (ivec2(i % 5, i / 5) - 2); }

// Which of 25 pixels over 25x25 have a like lobe, as bits.
uint far_pixels(ivec2 p, Shown here) {
    uint kept = 0u;
    for (int i = 0; i < 25; ++i) {
        const Shown there = shown(p + far_tap(i));
        if (there.z > 0.0 && dot(here.n, there.n) > 0.9 && alike(here.roughness, there.roughness)) kept |= 1u << uint(i);
    }
    return kept;
}

// What light that changes everywhere, a lamp that goes off, leaves below the noise of 5x5 pixels stands out of that of these.
// The square of the drift's mean over these, less what noise shows.
float far_drift(bool image_past, ivec2 p, vec2 uv, uint kept, float sigma2, float frames) {
    vec3 sum = vec3(0.0);
    float sums = 0.0, variance = 0.0;
    const ivec2 then = previous_texel(uv);
    for (int i = 0; i < 25; ++i) {
        if ((kept >> uint(i) & 1u) == 0u) continue;
        const ivec2 q = p + far_tap(i);
        const vec4 its = past(image_past, q);
        if (!(its.w > 0.0)) continue;
        const vec4 carried = carried_drift(then + far_tap(i));
        const Gathered g = gathered_at(q);
        const float deviation = max(g.deviation, carried.w);
        const vec3 term = g.radiance - its.rgb;
        const float size = length(term), limit = TERM_SIGMAS * deviation;
        sum += mix(carried.rgb, term * (size > limit ? limit / size : 1.0), DRIFT_SHARE);
        variance += deviation * deviation;
        sums += 1.0;
    }
    if (sums < 5.0) return 0.0;
    const float noise2 = SIGMAS * SIGMAS * max(variance / sums, sigma2) * (DRIFT_SHARE / (2.0 - DRIFT_SHARE) + 1.0 / frames) / sums;
    return dot(sum, sum) / (sums * sums) - noise2;
}

Candidate judge(bool image_past, ivec2 p, vec2 uv, float weights[25], Around around, uint far, bool moving) {
    const vec4 own = past(image_past, p);
    Candidate c = Candidate(own.rgb, vec3(0.0), own.w, 0.0, around.variance);
    if (!(own.w > 0.0)) return c;
    const vec4 carried = carried_drift(previous_texel(uv));
    c.variance_mean = mix(carried.w * carried.w, around.variance, VARIANCE_SHARE);
    const bool few = moving && around.samples < 4.0;
    float sigma2 = few ? around.variance : max(around.variance, c.variance_mean);
    if (!moving && around.samples < 6.0) sigma2 = max(sigma2, around.spread);
    const float limit = few ? 1e30 : TERM_SIGMAS * sqrt(sigma2);
    vec3 sum = vec3(0.0);
    float sums = 0.0;
    for (int i = 0; i < 25; ++i) {
        if (weights[i] == 0.0) continue;
        const ivec2 q = p + ivec2(i % 5, i / 5) - 2;
        const vec4 its = past(image_past, q);
        if (!(its.w > 0.0)) continue;
        const vec3 term = gathered_at(q).radiance - its.rgb;
        const float size = length(term);
        sum += weights[i] * term * (size > limit ? limit / size : 1.0);
        sums += weights[i];
    }
    const float share = few ? 1.0 : DRIFT_SHARE;
    c.drift = mix(carried.rgb, sum / sums, share);
    const float independent = around.samples < 3.0 ? 6.0 : 25.0;
    const float correlated = min(1.0, 1.3 * around.samples / (around.samples + independent) + 1.0 / independent);
    const float noise2 = SIGMAS * SIGMAS * correlated * sigma2 * (share / (2.0 - share) + 1.0 / own.w);
    float bias2 = max(dot(c.drift, c.drift) - noise2, 0.0);
    if (!few) bias2 = max(bias2, far_drift(image_past, p, uv, far, sigma2, own.w));
    // V = 1 / N + b^2 / sigma^2, its inverse without a quotient by a sigma of 0.
    c.worth = min(sigma2 * own.w / max(sigma2 + bias2 * own.w, 1e-30), MOST_FRAMES);
    if (sigma2 == 0.0) c.worth = bias2 == 0.0 ? min(own.w, MOST_FRAMES) : 0.0;
    return c;
}

// Whether this surface is the one that its 2x2 pixels keep the drift of: the first of theirs.
bool first_of_four(ivec2 p) {
    const int own = (p.x & 1) | (p.y & 1) << 1;
    for (int i = 0; i < own; ++i)
        if (imageLoad(view_depth, (p & ~1) + ivec2(i & 1, i >> 1)).x > 0.0) return false;
    return true;
}

void for_pixel(ivec2 p) {
    const Shown here = shown(p);
    if (!(here.z > 0.0)) {
        imageStore(accumulated, p, uvec4(0u));
        imageStore(frames, p, vec4(0.0));
        imageStore(deviation, p, vec4(0.0));
        return;
    }
    const Gathered g = gathered_at(p);
    float weights[25];
    window(p, here, weights);
    const Around around = look_around(p, weights);
    const uint far = far_pixels(p, here);
    const vec2 of_surface = past_of_surface(p), still = pixel_uv(p);
    const bool moving = HAS_MOTION && any(greaterThan(abs(of_surface - still) * vec2(frame.size), vec2(0.02)));
    Candidate best = judge(false, p, of_surface, weights, around, far, moving);
    if (LOBE == LOBE_SPECULAR) {
        const Candidate other = judge(true, p, past_of_image(p, here.z, g.distance_m), weights, around, far, moving);
        if (other.worth > best.worth) best = other;
    }
    // What moves is elsewhere in the mirror than any past expects.
    if (g.moving) best.worth = min(best.worth, MOVING_HIT_FRAMES);
    const float n = best.worth + 1.0;
    const vec3 mean = (best.worth * best.history + g.radiance) / n;
    const uvec2 kept = encode_past(Past(mean, n), thresholds_at(p));
    imageStore(accumulated, p, uvec4(kept.x));
    imageStore(frames, p, vec4(byte_texel(kept.y)));
    imageStore(deviation, p, vec4(min(sqrt(around.variance / n * max(1.0, 4.0 / n)), 65504.0)));
    if (first_of_four(p)) {
        const uint deviations = encode_deviations(vec2(sqrt(best.variance_mean), 0.0));
        imageStore(drift, p / 2, uvec4(encode_drift(best.worth > 0.0 ? best.drift : vec3(0.0)), deviations, 0u, 0u));
    }
}

void main() { for_each_pixel(); }
