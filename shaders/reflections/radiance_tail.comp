// SPDX-License-Identifier: MIT
// One level of an edge-aware filter over 3x3 pixels a step apart (Dammertz et al. 2010, "Edge-Avoiding A-Trous Wavelet
// Transform"), guided by the deviation that the signal carries (Schied et al. 2017): what is sure is left alone. Of the output
// alone; the past stays unfiltered.
//
// Every pair of pixels has one weight, which both use, and what one of them gives the other loses: the image's mean stays what it
// was. Weights of each pixel's own, divided by their sum, prefer what is frequent, which is what is dark: 2 to 3 % of the light.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/rounded.glsl"
#include "common/dithered.glsl"
#include "reflections/radiance_word.glsl"
#include "reflections/past_texel.glsl"
#include "common/same_surface.glsl"

float kernel(ivec2 o) { return (o.x == 0 ? 0.5 : 0.25) * (o.y == 0 ? 0.5 : 0.25); }

// A lobe turns twice as far as the normal, and is as wide as its alpha.
float lobe_width(float roughness) { return LOBE == LOBE_DIFFUSE ? 0.25 : 0.01 + 0.25 * roughness * roughness; }

// How many deviations a difference may have.
float tolerance(float roughness) {
    return LOBE == LOBE_DIFFUSE ? 4.0 : 1.0 + 3.0 * clamp(2.0 * (roughness - 0.2), 0.0, 1.0);
}

// The same whichever of the two asks.
float pair_weight(Shown a, Shown b, vec4 of_a, vec4 of_b) {
    if (!same_surface(a, b) || !same_surface(b, a)) return 0.0;
    const vec3 across = cross(a.n, b.n);
    const float wide_a = tolerance(a.roughness) * of_a.w, wide_b = tolerance(b.roughness) * of_b.w;
    const float width = sqrt(0.5 * (wide_a * wide_a + wide_b * wide_b)), lobe = lobe_width(min(a.roughness, b.roughness));
    return exp(-0.5 * dot(across, across) / (lobe * lobe) - length(of_a.rgb - of_b.rgb) / max(width, 1e-20));
}

// Radiance and its expected deviation; of the first level in an image each.
vec4 signal_at(ivec2 p) {
    if (HAS_SIGNAL) return imageLoad(signal, p);
    const Past past = decode_past(imageLoad(accumulated, p).x, texel_byte(imageLoad(frames, p).x));
    return vec4(past.radiance, imageLoad(deviation, p).x);
}

void for_pixel(ivec2 p) {
    const Shown here = shown(p);
    const vec4 own = signal_at(p);
    if (!(here.z > 0.0)) {
        store_filtered(p, own);
        return;
    }
    const ViewRays seen = view_rays(p, mat3(1.0));
    vec3 gained = vec3(0.0);
    float kept = 1.0, variance = 0.0, deviations = 0.0;
    for (int i = 0; i < 9; ++i) {
        if (i == 4) continue;
        const ivec2 o = ivec2(i % 3, i / 3) - 1, q = p + o * int(STEP);
        const Shown there = shown(q, seen, o * int(STEP));
        if (!(there.z > 0.0)) continue;
        const vec4 other = signal_at(q);
        const float weight = kernel(o) * pair_weight(here, there, own, other);
        gained += weight * (other.rgb - own.rgb);
        variance += weight * weight * other.w * other.w;
        deviations += weight * other.w;
        kept -= weight;
    }
    variance += kept * kept * own.w * own.w;
    deviations += kept * own.w;
    const float common_share = STEP == 1u ? 0.7 : STEP == 2u ? 0.4 : STEP == 4u ? 0.15 : 0.0;
    variance = mix(variance, deviations * deviations, common_share);
    store_filtered(p, vec4(own.rgb + gained, min(sqrt(variance), 65504.0)));
}

void main() { for_each_pixel(); }
