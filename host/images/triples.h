// SPDX-License-Identifier: MIT
// Three channels of an image that has them, pixel by pixel.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "host/images/image_file.h"

namespace penumbra {

inline std::vector<glm::vec3> triples(const PlanarImage& image, std::array<const char*, 3> channels) {
    std::vector<glm::vec3> out(size_t{image.width} * image.height);
    for (int c = 0; c < 3; ++c) {
        const std::vector<float>& values = image.find(channels[static_cast<size_t>(c)])->values;
        for (size_t i = 0; i < out.size(); ++i) out[i][c] = values[i];
    }
    return out;
}

}  // namespace penumbra
