// SPDX-License-Identifier: MIT
#include "host/materials/environment_lots.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace penumbra {
namespace {

constexpr double most_even = 3;

// Luminance of a texel, and of it and those around it.
class Brightness {
  public:
    explicit Brightness(const EnvironmentMap& map) : map_(map) {
        for (size_t i = 0; i < map.rgba.size(); i += 4)
            of_texel_.push_back(0.2126 * double(map.rgba[i]) + 0.7152 * double(map.rgba[i + 1]) +
                                0.0722 * double(map.rgba[i + 2]));
    }
    double of_texel(size_t i) const { return of_texel_[i]; }
    // The mean over a texel of what is interpolated between it and its neighbours.
    double around(uint32_t x, uint32_t y) const {
        constexpr double share[] = {0.125, 0.75, 0.125};
        const uint32_t w = map_.width, columns[] = {(x + w - 1) % w, x, (x + 1) % w},
                       rows[] = {y > 0 ? y - 1 : 0, y, std::min(y + 1, map_.height - 1)};
        double sum = 0;
        for (int v = 0; v < 3; ++v)
            for (int u = 0; u < 3; ++u)
                sum += share[v] * share[u] * of_texel_[size_t{rows[v]} * w + columns[u]];
        return sum;
    }

  private:
    const EnvironmentMap& map_;
    std::vector<double> of_texel_;
};

// Walker 1977, with Vose's tables (1991): each lot holds at most two texels, and all lots are alike.
std::vector<std::array<uint32_t, 4>> lots_of(const std::vector<double>& weights, double sum) {
    const size_t n = weights.size();
    std::vector<std::array<uint32_t, 4>> lots(n);
    std::vector<double> left(n);
    std::vector<uint32_t> small, large;
    for (uint32_t i = 0; i < n; ++i) {
        left[i] = weights[i] / sum * static_cast<double>(n);
        (left[i] < 1 ? small : large).push_back(i);
        lots[i] = {std::bit_cast<uint32_t>(1.0f), i, 0, 0};
    }
    while (!small.empty() && !large.empty()) {
        const uint32_t poor = small.back(), rich = large.back();
        small.pop_back();
        lots[poor] = {std::bit_cast<uint32_t>(static_cast<float>(left[poor])), rich, 0, 0};
        left[rich] -= 1 - left[poor];
        if (left[rich] >= 1) continue;
        large.pop_back();
        small.push_back(rich);
    }
    return lots;
}

}  // namespace

std::vector<std::array<uint32_t, 4>> environment_lots(const EnvironmentMap& map) {
    const Brightness brightness(map);
    const size_t texels = size_t{map.width} * map.height;
    std::vector<double> steradians(map.height), weights(texels);
    double mean = 0, square = 0;
    for (uint32_t y = 0; y < map.height; ++y) {
        const double step = std::numbers::pi / map.height;
        steradians[y] = 2 * std::numbers::pi / map.width * (std::cos(y * step) - std::cos((y + 1) * step));
        for (uint32_t x = 0; x < map.width; ++x) {
            const double value = brightness.of_texel(size_t{y} * map.width + x),
                         share = steradians[y] / (4 * std::numbers::pi);
            mean += share * value;
            square += share * value * value;
        }
    }
    if (!(square - mean * mean > most_even * mean * mean)) return {};
    double sum = 0;
    for (uint32_t y = 0; y < map.height; ++y)
        for (uint32_t x = 0; x < map.width; ++x)
            sum += weights[size_t{y} * map.width + x] =
                steradians[y] * std::max(brightness.around(x, y) - mean, 0.0);
    std::vector<std::array<uint32_t, 4>> lots = lots_of(weights, sum);
    for (size_t i = 0; i < texels; ++i)
        lots[i][2] =
            std::bit_cast<uint32_t>(static_cast<float>(weights[i] / (sum * steradians[i / map.width])));
    lots.insert(lots.begin(), {map.width, map.height, 0, 0});
    return lots;
}

}  // namespace penumbra
