// SPDX-License-Identifier: MIT
// The unit square to the unit disc, areas kept: Shirley and Chiu 1997, "A Low Distortion Map Between Disk and
// Square". Strata of the square become compact pieces of the disc, of which an edge crosses few:
// host/metrics/mask_error.cpp counts them.
#pragma once

#include <cmath>
#include <glm/vec2.hpp>
#include <numbers>

namespace penumbra {

// u, v: in [0, 1].
inline glm::dvec2 concentric_disc(double u, double v) {
    const double x = 2 * u - 1, y = 2 * v - 1;
    if (x == 0 && y == 0) return {0, 0};
    const bool wide = std::abs(x) > std::abs(y);
    const double angle = std::numbers::pi / 4 * (wide ? y / x : x / y), r = wide ? x : y;
    return wide ? glm::dvec2(r * std::cos(angle), r * std::sin(angle))
                : glm::dvec2(r * std::sin(angle), r * std::cos(angle));
}

}  // namespace penumbra
