// SPDX-License-Identifier: MIT
// What the passes of RELAX share: NVIDIA's denoiser of radiance by a past and a filter that its variance guides, as a baseline.
// Written from a description of what the published one computes (docs/reflections.md says what was read); no code of theirs is in
// here. `roughness` is the perceptual one.
//
// Includer has common/same_surface.glsl and declares: constant LOBE.

const float PLANE_TOLERANCE = 0.003;  // of the depth: how far off a pixel's plane another one still counts

// Two falling weights of a difference in units of what is allowed: the first ends at 1, the second never.
float smooth_weight(float x) { return 1.0 - smoothstep(0.0, 1.0, abs(x)); }
float lasting_weight(float x) { return 1.0 / (1.0 + 3.0 * abs(x) + 9.0 * x * x); }

// Tangent of the angle from the normal within which half of GGX's normals lie: their share within t is t^2 / (alpha^2 + t^2). Of the
// cosine that of the roughest.
float lobe_tangent(float roughness) { return LOBE == LOBE_DIFFUSE ? 1.0 : roughness * roughness; }

const float NORMAL_ERROR = 6.5e-5;  // of the octahedral words (common/receiver_normal.glsl)

// Less what the words may make of none.
float angle_between(vec3 a, vec3 b) { return max(atan(length(cross(a, b)), dot(a, b)) - 2.0 * NORMAL_ERROR, 0.0); }

// Surfaces that could be one, and as rough.
bool coplanar(Shown here, Shown there) {
    return there.z > 0.0 && abs(dot(here.n, there.x - here.x)) <= PLANE_TOLERANCE * here.z;
}
float roughness_weight(Shown here, Shown there) {
    return LOBE == LOBE_DIFFUSE ? 1.0 : smooth_weight((here.roughness - there.roughness) / (0.01 + 0.15 * here.roughness));
}

// How far another pixel may stand for this one.
float likeness(Shown here, Shown there) {
    if (!coplanar(here, there)) return 0.0;
    return roughness_weight(here, there) * smooth_weight(angle_between(here.n, there.n) / max(lobe_tangent(here.roughness), 1e-4));
}

// Pixels that what a surface mirrors may be blurred over: as far as a part of its lobe reaches at the reflected thing's distance.
// Half of the lobe blurs .05 to .15 twice as much, a quarter leaves first frames with a third of the rays.
const float LOBE_PART = 0.35;
float footprint_px(Shown here, float distance_m) {
    return LOBE_PART * distance_m * lobe_tangent(here.roughness) / pixel_span_m(here.z);
}
