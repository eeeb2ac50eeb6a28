// SPDX-License-Identifier: MIT
// The light is the node shade's default (nodes/lighting/shade.json).
#include "host/metrics/shaded.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <stdexcept>

#include "host/metrics/radiance_error.h"

namespace penumbra {
namespace {

constexpr glm::vec3 sun_color(3.0f, 2.8f, 2.5f), ambient(0.16f, 0.19f, 0.24f);

}  // namespace

std::vector<glm::vec3> shade_surfaces(const Surfaces& surfaces, const ComparedFrame& frame,
                                      std::span<const float> visibility) {
    const size_t pixels = frame.pixels();
    if (surfaces.albedo.size() != pixels || surfaces.normal.size() != pixels || visibility.size() != pixels)
        throw std::invalid_argument("shade_surfaces: images of different sizes");
    const glm::vec3 to_sun(surfaces.to_sun);
    std::vector<glm::vec3> out(pixels, glm::vec3(0));
    for (size_t p = 0; p < pixels; ++p) {
        if (!frame.counted[p]) continue;
        const float v = std::isfinite(visibility[p]) ? visibility[p] : frame.truth[p] > 0.5f ? 0.0f : 1.0f;
        const float direct = std::max(glm::dot(surfaces.normal[p], to_sun), 0.0f) * v;
        out[p] = surfaces.albedo[p] * (sun_color * direct + ambient);
    }
    return out;
}

std::vector<glm::vec3> display_linear(std::span<const glm::vec3> radiance) {
    const glm::vec3 white = sun_color + ambient;
    const float exposure = 1 / std::max({white.x, white.y, white.z});
    std::vector<glm::vec3> out;
    out.reserve(radiance.size());
    for (const glm::vec3& r : radiance) out.push_back(glm::clamp(exposure * r, 0.0f, 1.0f));
    return out;
}

RelativeErrorSum relative_error(const ComparedFrame& frame, std::span<const glm::vec3> image,
                                std::span<const glm::vec3> truth) {
    if (image.size() != frame.pixels() || truth.size() != frame.pixels())
        throw std::invalid_argument("relative_error: images of different sizes");
    RelativeErrorSum out;
    for (size_t p = 0; p < image.size(); ++p) {
        if (!frame.counted[p]) continue;
        for (int c = 0; c < 3; ++c) {
            const auto a = static_cast<double>(image[p][c]), b = static_cast<double>(truth[p][c]);
            out.sum += (a - b) * (a - b) / (b * b + darkest_squared);
            ++out.values;
        }
    }
    return out;
}

}  // namespace penumbra
