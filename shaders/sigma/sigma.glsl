// SPDX-License-Identifier: MIT
// What the passes of SIGMA share: NVIDIA's denoiser of shadows whose rays know the distance of what they hit, as a baseline.
// Written from a description of what the published one computes (docs/pipelines.md says what was read); no code of theirs is in here.
//
// Includer declares: block frame.
#include "sigma/values.glsl"

const float MAX_RADIUS_PX = 32.0;
const int TILE_PX = 16;
const float PLANE_SENSITIVITY = 0.02;  // of the frustum's height: how far off a pixel's plane another one still counts

ivec2 tile_grid() { return (ivec2(frame.size) + TILE_PX - 1) / TILE_PX; }

// Pixels that touch their blockers, or are turned away, keep to themselves.
bool of_a_kind(float a, float b) { return (a == 0.0) == (b == 0.0); }

// Radius in pixels of a penumbra of `radius_px`, scaled: tiny ones keep their size, others are left 2 pixels at least.
float kernel_radius(float radius_px, float scale) { return clamp(radius_px * scale, min(radius_px, 2.0), MAX_RADIUS_PX); }

// The square of an image's values: eight bits spend more of their steps on what is dark. A shadow is the visibility and the
// colour of what arrives; where there is none, four times the same, which compilers do once.
vec4 decoded(vec4 s) { return s * s; }
