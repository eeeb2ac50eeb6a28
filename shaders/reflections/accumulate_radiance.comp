// SPDX-License-Identifier: MIT
// Each pixel's past receives what was gathered, weighted by how far it can be believed: the drift between the two, averaged
// over 5x5 similar pixels and over time, less what noise alone would show, is the past's bias; with 1 / frames it is its error
// in units of the gather's, and of the two pasts that of the smaller drift wins. Nothing is clamped beyond this.
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
#include "common/past_places.glsl"
#include "common/same_surface.glsl"

const float MOST_FRAMES = 63.0, TERM_SIGMAS = 4.0;
const float SIGMAS = 3.0, SIGMAS_AT_REST = 3.5;  // at rest light alone changes: a past is doubted later
const float FEW = 4.0, LONE = 2.0;  // samples of a gather, in motion: fewer
const float WIDE = 1.4;  // pixels' angles
const float DRIFT_SHARE = 0.4;  // of the new value in the running mean
const int FAR_STEP = 5;  // px between the pixels of Far: a gather's window, so that no two share a ray

Gathered gathered_at(ivec2 p) { return decode_gathered(imageLoad(gathered, p).xy); }

// Means over similar pixels.
struct Around {
    float variance, samples, spread;
};

// Of the 25 pixels around, and their weights: 6, 4, 1 along an axis.
ivec2 near_tap(int i) { return ivec2(i % 5, i / 5) - 2; }
float near_weight(int i) {
    const vec2 o = abs(vec2(near_tap(i))), weights = 6.0 - 0.5 * o * (o + 3.0);
    return weights.x * weights.y;
}

// `near`: which of them show the same surface, as bits; an array of weights would lie in memory, as no register can be asked by number.
Around look_around(ivec2 p, Shown here, out uint near) {
    const OffPlane plane = off_plane(view_rays(p, mat3(1.0)), here.n, here.x);
    near = 0u;
    float sum = 0.0, variance = 0.0, samples = 0.0, squares = 0.0;
    vec3 mean = vec3(0.0);
    for (int i = 0; i < 25; ++i) {
        const ivec2 o = near_tap(i);
        const uvec2 there = surface_texel(p + o);
        const float z = surface_depth(there);
        const bool on_it = z > 0.0 && abs(metres_off(plane, vec2(o), z)) < ON_PLANE * here.z && like_lobe(here, there);
        if (on_it || i == 12) {
            near |= 1u << uint(i);
            const Gathered g = gathered_at(p + o);
            const float weight = g.samples > 0.0 ? near_weight(i) : 0.0;
            sum += weight;
            variance += weight * g.deviation * g.deviation;
            samples += weight * g.samples;
            mean += weight * g.radiance;
            squares += weight * dot(g.radiance, g.radiance);
        }
    }
    if (!(sum > 0.0)) return Around(0.0, 0.0, 0.0);
    mean /= sum;
    return Around(variance / sum, samples / sum, max(squares / sum - dot(mean, mean), 0.0));
}

// What a past would leave.
struct Candidate {
    vec3 history;
    float worth;   // N', 0 without a past
    float error2;  // expected, noise of the drift and all: both candidates are compared with the same gather
    Drift drift;
};

Drift drift_at(ivec2 then) {
    return decode_drift(imageLoad(drift_prev, clamp(then, ivec2(0), ivec2(frame.prev_size) - 1) / 2).xy);
}

// A lone sample shows no variance. What its neighbours' spread shows is noise where a lobe is wider than the mirrored directions of two
// pixels lie apart, and what is mirrored where it is narrower.
float variance_of_lone(Around around, float roughness) {
    const float apart = (frame.flags & FRAME_ORTHOGRAPHIC) != 0u ? 0.0 : WIDE * frame.pixel_angle;
    const float wide = min(roughness * roughness / max(apart, 1e-6), 1.0);
    return max(around.variance, around.spread * wide * wide * wide * wide);
}

// The two pasts of a pixel: a word each, and their bytes.
struct Pasts {
    uvec2 words, bytes;
};

Pasts pasts_at(ivec2 q) {
    if (HAS_HISTORY) {
        if (!pixels_have_pasts()) return Pasts(uvec2(0u), uvec2(0u));
        return Pasts(uvec2(imageLoad(history, q).x, 0u), uvec2(texel_byte(imageLoad(frames_prev, q).x), 0u));
    }
    const vec2 bytes = imageLoad(past_frames, q).xy;
    Pasts pasts = Pasts(uvec2(imageLoad(past_surface, q).x, 0u), uvec2(texel_byte(bytes.x), texel_byte(bytes.y)));
    if (HAS_PAST_IMAGE && has_past(pasts.bytes.y)) pasts.words.y = imageLoad(past_image, q).x;
    return pasts;
}

// What the neighbours' gathers differ from their pasts by.
struct Terms {
    vec3 sum;
    float weight;
};

void add(inout Terms terms, float weight, vec3 radiance, uint word, uint byte, float limit) {
    const vec3 term = radiance - past_radiance(word, byte);
    const float size = length(term), counts = has_past(byte) ? weight : 0.0;
    terms.sum += counts * (size > limit ? limit / size : 1.0) * term;
    terms.weight += counts;
}

// A past that may be believed, before its neighbours are asked.
struct Asked {
    Past own;
    ivec2 then;  // previous frame's pixel
    Drift carried;
    float sigma2, limit;  // variance of a frame; what no term is longer than
};

// `least2`: variance of a frame, at least.
Asked asked(Past own, vec2 uv, float least2, bool few) {
    const ivec2 then = previous_texel(uv);
    const Drift carried = drift_at(then);
    const float sigma2 = max(least2, few ? 0.0 : carried.of_past2 * own.frames);
    return Asked(own, then, carried, sigma2, few ? 1e30 : TERM_SIGMAS * sqrt(sigma2));
}

// What light that changes everywhere, a lamp that goes off, leaves below the noise of 5x5 pixels stands out of that of 25 over 25x25, of
// those with a like lobe: sums of their drifts of the last frame.
struct Far {
    vec3 sum;
    float variances, pixels;
};

void add(inout Far far, ivec2 then) {
    const Drift its = drift_at(then);
    far.sum += its.mean;
    far.variances += its.of_mean2 + its.of_past2;
    far.pixels += 1.0;
}

// The square of their mean, less what noise shows.
float bias2_of(Far far, float variance, float sigmas) {
    if (far.pixels < 5.0) return 0.0;
    return dot(far.sum, far.sum) / (far.pixels * far.pixels) - sigmas * sigmas * max(far.variances / far.pixels, variance) / far.pixels;
}

Candidate judge(Asked a, Terms terms, float samples, float variance, Far far, bool moving, bool few) {
    const Past own = a.own;
    if (!(own.frames > 0.0)) return Candidate(own.radiance, 0.0, 1e30, Drift(vec3(0.0), 0.0, 0.0));
    if (!(terms.weight > 0.0)) return Candidate(own.radiance, min(own.frames, MOST_FRAMES), 0.0, a.carried);
    const float share = few ? 1.0 : DRIFT_SHARE;
    const Drift drift = Drift(mix(a.carried.mean, terms.sum / terms.weight, share),
                              (1.0 - share) * (1.0 - share) * a.carried.of_mean2 + share * share * variance,
                              few ? variance / own.frames : a.carried.of_past2);
    const float independent = samples < 3.0 ? 6.0 : 25.0;
    const float correlated = min(1.0, 1.3 * samples / (samples + independent) + 1.0 / independent);
    const float noise2 = correlated * (drift.of_mean2 + drift.of_past2);
    const float sigmas = moving ? SIGMAS : SIGMAS_AT_REST;
    float bias2 = max(dot(drift.mean, drift.mean) - sigmas * sigmas * noise2, 0.0);
    bias2 = max(bias2, bias2_of(far, noise2, sigmas));
    // V = 1 / N + b^2 / sigma^2, its inverse without a quotient by a sigma of 0.
    float worth = min(a.sigma2 * own.frames / max(a.sigma2 + bias2 * own.frames, 1e-30), MOST_FRAMES);
    if (a.sigma2 == 0.0) worth = bias2 == 0.0 ? min(own.frames, MOST_FRAMES) : 0.0;
    return Candidate(own.radiance, worth, dot(drift.mean, drift.mean) + a.sigma2 / own.frames, drift);
}

// The better of the two.
Candidate best_past(ivec2 p, Shown here, float distance_m, uint near, Around around, float variance, bool moving, vec2 of_surface) {
    const bool few = moving && around.samples < FEW;
    const float least2 = moving && around.samples < LONE ? variance_of_lone(around, here.roughness) : variance;
    const Pasts own = pasts_at(p);
    const Asked surface = asked(decode_past(own.words.x, own.bytes.x), of_surface, least2, few);
    Asked image = surface;
    if (HAS_PAST_IMAGE) image = asked(decode_past(own.words.y, own.bytes.y), past_of_image(p, here.z, distance_m), least2, few);
    Terms surface_terms = Terms(vec3(0.0), 0.0), image_terms = surface_terms;
    for (int i = 0; i < 25; ++i) {
        if ((near >> uint(i) & 1u) == 0u) continue;
        const ivec2 q = p + near_tap(i);
        const Gathered g = gathered_at(q);
        const Pasts its = pasts_at(q);
        const float weight = g.samples > 0.0 ? near_weight(i) : 0.0;
        add(surface_terms, weight, g.radiance, its.words.x, its.bytes.x, surface.limit);
        if (HAS_PAST_IMAGE && has_past(its.bytes.y)) add(image_terms, weight, g.radiance, its.words.y, its.bytes.y, image.limit);
    }
    Far surface_far = Far(vec3(0.0), 0.0, 0.0), image_far = surface_far;
    for (int i = 0; i < (few ? 0 : 25); ++i) {
        const ivec2 o = FAR_STEP * near_tap(i);
        const uvec2 there = surface_texel(p + o);
        if (surface_depth(there) > 0.0 && like_lobe(here, there)) {
            add(surface_far, surface.then + o);
            if (HAS_PAST_IMAGE && image.own.frames > 0.0) add(image_far, image.then + o);
        }
    }
    const Candidate best = judge(surface, surface_terms, around.samples, variance, surface_far, moving, few);
    if (!HAS_PAST_IMAGE) return best;
    const Candidate other = judge(image, image_terms, around.samples, variance, image_far, moving, few);
    if (other.error2 < best.error2) return other;
    return best;
}

// Which of 2x2 pixels keeps their drift: the first that shows a surface, or the first.
bool keeps_drift(ivec2 p) {
    const ivec2 first = p & ~1;
    for (int i = 0; i < 4; ++i) {
        const ivec2 q = first + ivec2(i & 1, i >> 1);
        if (inside_frame(q) && surface_depth(imageLoad(surface, q).xy) > 0.0) return q == p;
    }
    return p == first;
}

void for_pixel(ivec2 p) {
    const Shown here = shown(p);
    if (!(here.z > 0.0)) {
        store_accumulated(p, uvec4(0u));
        store_frames(p, vec4(0.0));
        store_deviation(p, vec4(0.0));
        if (keeps_drift(p)) store_drift(p / 2, uvec4(encode_drift(Drift(vec3(0.0), 0.0, 0.0)), 0u, 0u));
        return;
    }
    const Gathered g = gathered_at(p);
    uint near;
    const Around around = look_around(p, here, near);
    const vec2 of_surface = past_of_surface(p), still = pixel_uv(p);
    const bool moving = HAS_MOTION && any(greaterThan(abs(of_surface - still) * vec2(frame.size), vec2(0.02)));
    // Few samples at rest know less of their variance than their neighbours show.
    const float variance = !moving && around.samples < 6.0 ? max(around.variance, around.spread) : around.variance;
    Candidate best = best_past(p, here, g.distance_m, near, around, variance, moving, of_surface);
    // What moves is elsewhere in the mirror than any past expects.
    if (g.moving) best.worth = min(best.worth, MOVING_HIT_FRAMES);
    const float own = g.samples > 0.0 || !(best.worth > 0.0) ? 1.0 : 0.0, n = best.worth + own;  // without a ray around there is the past alone
    const vec3 mean = (best.worth * best.history + own * g.radiance) / n;
    const uvec2 kept = encode_past(Past(mean, n), thresholds_at(p));
    store_accumulated(p, uvec4(kept.x));
    store_frames(p, vec4(byte_texel(kept.y)));
    const float of_past2 = (best.worth * best.worth * best.drift.of_past2 + own * variance) / (n * n);
    const float expected2 = max(around.variance / n, around.samples < 2.0 ? 0.0 : of_past2);
    store_deviation(p, vec4(min(sqrt(expected2 * max(1.0, 4.0 / n)), 65504.0)));
    // A past that is left behind takes its drift along.
    const Drift kept_drift = best.worth > 0.0 ? Drift(best.drift.mean, best.drift.of_mean2, of_past2) : Drift(vec3(0.0), 0.0, of_past2);
    if (keeps_drift(p)) store_drift(p / 2, uvec4(encode_drift(kept_drift), 0u, 0u));
}

void main() { for_each_pixel(); }
