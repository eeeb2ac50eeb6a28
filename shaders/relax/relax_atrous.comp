// SPDX-License-Identifier: MIT
// RELAX, one level of its filter over 3x3 pixels a step apart (Dammertz et al. 2010, "Edge-Avoiding A-Trous Wavelet Transform"),
// guided by the variance (Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering").
//
// Published, and kept: weights are each pixel's own and divided by their sum, which prefers what is frequent and dark.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/hash.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/rounded.glsl"
#include "common/same_surface.glsl"
#include "relax/light.glsl"
#include "relax/relax.glsl"
#include "relax/frames.glsl"

const float KERNEL[2] = float[](0.44198, 0.27901);
const float DIFFUSE_DEVIATIONS = 2.0, SPECULAR_DEVIATIONS = 1.0;
const float LOBE_SHARE = 0.5;        // of the lobe's angle
const float SHORT_LOBE_SHARE = 0.99;  // where the past is shorter than
const float SHORT = 5.0;

// What a difference of lobes counts: of the half vectors, by the surfaces' normals and half of the angle between views. Lobes may
// differ by a share of their own angle; normals by ten times that where no past is trusted, which is when there is most to blur.
// Published with .15 degrees more for any lobe: three pixels of an image of 1080, in which every mirror would be blurred.
struct Lobe {
    float angle, trusted;
};

Lobe own_lobe(ivec2 p, Shown here) {
    const float angle = atan(lobe_tangent(here.roughness));
    if (LOBE == LOBE_SPECULAR) return Lobe(angle * LOBE_SHARE, imageLoad(confidence, p).x);
    const float share = decode_frames(imageLoad(frames, p).x) < SHORT ? SHORT_LOBE_SHARE : LOBE_SHARE;
    return Lobe(angle * share / sqrt(float(STEP)), 1.0);
}

float lobe_weight(Lobe lobe, Shown here, Shown there) {
    const float normals = angle_between(here.n, there.n);
    if (LOBE == LOBE_DIFFUSE) return smooth_weight(normals / lobe.angle);
    const bool parallel = (frame.flags & FRAME_ORTHOGRAPHIC) != 0u;
    const float views = parallel ? 0.0 : 0.5 * length(cross(here.x, there.x)) / (length(here.x) * length(there.x));
    return smooth_weight((normals / (10.0 - 9.0 * lobe.trusted) + views) / max(lobe.angle, 1e-6));
}

// Steps beyond 4 are not the same for all pixels, which keeps what is bright from ringing.
ivec2 shifted(ivec2 p) {
    if (STEP <= 4u) return ivec2(0);
    const uint first = noise_hash(uint(p.x) ^ noise_hash(uint(p.y) ^ noise_hash(frame.frame_index ^ STEP)));
    return ivec2(floor((noise_unit(uvec2(first, noise_hash(first))) - 0.5) * 0.5 * float(STEP) + 0.5));
}

void for_pixel(ivec2 p) {
    const Shown here = shown(p);
    const vec4 own = imageLoad(signal, p);
    if (!(here.z > 0.0)) {
        store_filtered(p, own);
        return;
    }
    const float light = luminance(own.rgb), width = max((LOBE == LOBE_DIFFUSE ? DIFFUSE_DEVIATIONS : SPECULAR_DEVIATIONS) * own.w, 1e-4);
    const Lobe lobe = own_lobe(p, here);
    const ivec2 shift = shifted(p);
    float weights = KERNEL[0] * KERNEL[0];
    vec3 sum = weights * own.rgb;
    float variance = weights * weights * own.w * own.w;
    for (int i = 0; i < 9; ++i) {
        if (i == 4) continue;
        const ivec2 o = ivec2(i % 3, i / 3) - 1, q = p + o * int(STEP) + shift;
        const Shown there = shown(q);
        if (!(there.z > 0.0) || !coplanar(here, there)) continue;
        const vec4 other = imageLoad(signal, q);
        const float weight = KERNEL[abs(o.x)] * KERNEL[abs(o.y)] * lobe_weight(lobe, here, there) * roughness_weight(here, there) *
                             exp(-abs(luminance(other.rgb) - light) / width);
        sum += weight * other.rgb;
        variance += weight * weight * other.w * other.w;
        weights += weight;
    }
    store_filtered(p, vec4(sum / weights, sqrt(variance) / weights));
}

void main() { for_each_pixel(); }
