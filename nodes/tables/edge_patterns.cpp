// SPDX-License-Identifier: MIT
// The expectation is over straight edges and strips of all directions and places, with the penumbra of a
// disc: one sum over a regular grid of such shadows, each with the probability that its nine rays return the
// pattern. Half of the shadows are strips, because a world of single edges would take every pole and leaf for
// noise.
#include "nodes/tables/edge_patterns.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace penumbra {
namespace {

using std::numbers::pi;

constexpr int directions = 48, places = 56;
constexpr double reach_px = 3.5;  // further away an edge leaves nine equal bits
// Penumbra widths; the step, twice, stands for all shadows that are sharper than a pixel.
constexpr std::array widths_px{0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0};
constexpr std::array strips_px{0.75, 1.25, 2.0, 3.0, 4.5};

// Of a point `distance` inside the light of a half-plane whose penumbra is `width` wide, under a disc-shaped
// sun.
double half_plane_visibility(double distance, double width) {
    if (width == 0.0) return distance > 0.0 ? 1.0 : 0.0;
    const double d = std::clamp(2.0 * distance / width, -1.0, 1.0);
    return 0.5 + (std::asin(d) + d * std::sqrt(1.0 - d * d)) / pi;
}

struct Sums {
    std::array<double, edge_pattern_count> weight{}, visibility{};

    // A shadow and its negative, whose bits are all the others.
    void add(const std::array<double, 9>& lit, double weight_of_both) {
        std::array<double, edge_pattern_count> probability{weight_of_both};
        for (uint32_t i = 0, count = 1; i < 9; ++i, count *= 2)
            for (uint32_t k = 0; k < count; ++k) {
                probability[k + count] = probability[k] * lit[i];
                probability[k] *= 1.0 - lit[i];
            }
        const double v = lit[4];
        for (uint32_t k = 0; k < edge_pattern_count; ++k) {
            const uint32_t negative = edge_pattern_count - 1 - k;
            weight[k] += probability[k];
            visibility[k] += v * probability[k];
            weight[negative] += probability[k];
            visibility[negative] += (1.0 - v) * probability[k];
        }
    }
};

// `strip_px`: 0 for a half-plane.
void add_shadows(Sums& sums, double width_px, double strip_px, double weight) {
    for (int i = 0; i < directions; ++i)
        for (int j = 0; j < places; ++j) {
            const double angle = 2.0 * pi * (i + 0.5) / directions;
            const double place = reach_px * (2.0 * (j + 0.5) / places - 1.0);
            std::array<double, 9> lit{};
            for (int k = 0; k < 9; ++k) {
                const double d = std::cos(angle) * (k % 3 - 1) + std::sin(angle) * (k / 3 - 1) + place;
                lit[k] = half_plane_visibility(d, width_px);
                if (strip_px > 0.0) lit[k] -= half_plane_visibility(d - strip_px, width_px);
            }
            sums.add(lit, weight);
        }
}

}  // namespace

EdgePatterns edge_patterns() {
    Sums sums;
    for (const double width : widths_px) {
        add_shadows(sums, width, 0.0, 1.0);
        for (const double strip : strips_px) add_shadows(sums, width, strip, 1.0 / strips_px.size());
    }
    EdgePatterns patterns;
    for (uint32_t k = 0; k < edge_pattern_count; ++k) patterns[k] = sums.visibility[k] / sums.weight[k];
    // Nine equal bits mostly lie far from any edge, where the sums do not look: umbra stays 0, light stays 1.
    patterns.front() = 0;
    patterns.back() = 1;
    return patterns;
}

std::vector<uint8_t> edge_pattern_table() {
    std::vector<uint8_t> texels;
    for (const double visibility : edge_patterns())
        texels.push_back(static_cast<uint8_t>(std::lround(255.0 * visibility)));
    return texels;
}

}  // namespace penumbra
