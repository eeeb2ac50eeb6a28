// SPDX-License-Identifier: MIT
// Where a point of an image lies among its pixels' centres.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace penumbra {

// Four pixels and their weights; those of weight 0 repeat a neighbour.
struct BilinearTaps {
    std::array<size_t, 4> pixels{};
    std::array<double, 4> weights{};

    double of(std::span<const float> image) const {
        double sum = 0;
        for (size_t i = 0; i < 4; ++i)
            if (weights[i] > 0) sum += weights[i] * static_cast<double>(image[pixels[i]]);
        return sum;
    }
};

// At (x, y) in pixels, centres at halves; absent where a pixel with weight would lie outside.
inline std::optional<BilinearTaps> bilinear_taps(double x, double y, uint32_t width, uint32_t height) {
    const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
    const double fx = x - 0.5 - left, fy = y - 0.5 - top;
    if (!(left >= 0 && top >= 0 && left + (fx > 0) < width && top + (fy > 0) < height)) return std::nullopt;
    const size_t p = static_cast<size_t>(top) * width + static_cast<size_t>(left);
    const size_t right = fx > 0 ? 1 : 0, down = fy > 0 ? width : 0;
    return BilinearTaps{{p, p + right, p + down, p + down + right},
                        {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy}};
}

}  // namespace penumbra
