// SPDX-License-Identifier: MIT
// FLIP for displayable images: the difference that a person sees who flips between two images (Andersson,
// Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild: "FLIP: A Difference Evaluator for Alternating
// Images", HPG 2020). 0: equal; 1: pure green against pure blue.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

namespace penumbra {

// A 3840 pixel wide, 0.7 m wide monitor seen from 0.7 m, the paper's: pi / 180 * 3840.
constexpr double flip_pixels_per_degree = 67.02;

// Difference per pixel of two images of linear sRGB in 0 .. 1 (values outside are clipped).
std::vector<float> flip_map(uint32_t width, uint32_t height, std::span<const glm::vec3> reference,
                            std::span<const glm::vec3> image,
                            double pixels_per_degree = flip_pixels_per_degree);

// `weighted_median`: half of the map's sum lies below it; `p95`: 95 % of the pixels do.
struct FlipPool {
    double mean = 0, weighted_median = 0, p95 = 0;
};
// Absent for no values.
std::optional<FlipPool> pool_flip(std::vector<float> values);

}  // namespace penumbra
