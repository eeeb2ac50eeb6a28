// SPDX-License-Identifier: MIT
// How much of white surroundings a rough mirror reflects (the split sum's second half: Karis 2013, "Real
// Shading in Unreal Engine 4"): the table of the node `compose`, made at build time. The lobe is that of
// shaders/reflections/lobe.glsl: GGX with Smith's height-correlated masking.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace penumbra {

struct EnvironmentBrdf {
    double white = 0;    // of a mirror whose Fresnel term is 1; less than 1 where light would bounce again
    double grazing = 0;  // the part of it that is weighted by Schlick's (1 - v.h)^5
};

// By quadrature over the lobe, right to 1e-3. `n_v`: cosine of the view, `roughness`: perceptual; both 0 to
// 1.
EnvironmentBrdf environment_brdf(double n_v, double roughness);

// Texel (x, y) holds n_v = x / 63, roughness = y / 31.
inline constexpr std::array<uint32_t, 2> environment_brdf_size{64, 32};

// Two floats per texel, row by row.
std::vector<float> environment_brdf_table();

// What compose.comp reads there: bilinear.
EnvironmentBrdf look_up(const std::vector<float>& table, double n_v, double roughness);

}  // namespace penumbra
