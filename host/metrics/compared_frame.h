// SPDX-License-Identifier: MIT
// What every metric looks at: one frame's truth and the images that are to be judged by it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace penumbra {

constexpr double penumbra_eps = 1.0 / 256;  // penumbra: eps <= truth <= 1 - eps

inline bool in_penumbra(double truth) {
    return truth >= penumbra_eps && truth <= 1 - penumbra_eps;
}

// All images are rows from the top. The spans belong to the caller.
struct ComparedFrame {
    uint32_t width = 0, height = 0;
    std::span<const float> truth;                // visibility, 0 .. 1
    std::span<const uint8_t> counted;            // receivers that are to be measured
    std::vector<std::span<const float>> seeds;   // the same image under one or more seeds
    std::span<const float> reference_rays = {};  // per pixel, behind the truth; empty: a closed form

    size_t pixels() const { return size_t{width} * height; }
};

// Throws std::invalid_argument, with the caller's name, where sizes differ or there is no seed.
void check_sizes(const ComparedFrame& frame, const char* caller);

}  // namespace penumbra
