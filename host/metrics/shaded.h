// SPDX-License-Identifier: MIT
// What a mask's error does to the picture. Image and truth are lit by the same formula, that of the node
// `shade` with its default light, so that nothing but the mask differs: albedo * (sun * n.s * v + ambient).
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "host/metrics/compared_frame.h"

namespace penumbra {

struct Surfaces {
    std::span<const glm::vec3> albedo;  // linear
    std::span<const glm::vec3> normal;  // unit, world axes
    glm::dvec3 to_sun{0, 0, 1};         // unit
};

// Linear radiance per pixel; pixels that do not count are black.
std::vector<glm::vec3> shade_surfaces(const Surfaces& surfaces, const ComparedFrame& frame,
                                      std::span<const float> visibility);

// Linear display values in 0 .. 1: scaled so that a white surface that faces the sun is white, then clipped.
std::vector<glm::vec3> display_linear(std::span<const glm::vec3> radiance);

// Mean over pixels and channels of (image - truth)^2 / (truth^2 + .01), as the literature on denoising has
// it.
struct RelativeErrorSum {
    double sum = 0;
    uint64_t values = 0;

    void add(const RelativeErrorSum& other) {
        sum += other.sum;
        values += other.values;
    }
    std::optional<double> mean() const {
        return values ? std::optional(sum / static_cast<double>(values)) : std::nullopt;
    }
};
RelativeErrorSum relative_error(const ComparedFrame& frame, std::span<const glm::vec3> image,
                                std::span<const glm::vec3> truth);

}  // namespace penumbra
