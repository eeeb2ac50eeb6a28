// SPDX-License-Identifier: MIT
// Lots that rays towards the environment are drawn by: texels brighter than the mean, by how much they are
// and how large. A direction's density then is known, so that such rays and those of a lobe can be weighted
// together. In four words each: first the map's width and height; then of every texel the chance to be kept
// when it is drawn, evenly, which one is taken instead, and the density of its directions per steradian
// (shaders/reflections/environment_lots.glsl).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/materials/environment.h"

namespace penumbra {

// None where the map is even enough for a lobe's own rays: a ray drawn evenly has a variance of at most three
// times the square of its mean.
std::vector<std::array<uint32_t, 4>> environment_lots(const EnvironmentMap& map);

}  // namespace penumbra
