// SPDX-License-Identifier: MIT
// The table of 3x3 shadow bits: its symmetries, and what it gains over the pixel's own ray on shadows that it
// was not made from: edges and strips drawn at random, one ray per pixel.
#include "nodes/tables/edge_patterns.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace penumbra::test {
namespace {

const EdgePatterns& patterns() {
    static const EdgePatterns all = edge_patterns();
    return all;
}

template <typename Place>
uint32_t moved(uint32_t pattern, const Place& place) {
    uint32_t result = 0;
    for (uint32_t i = 0; i < 9; ++i)
        if ((pattern >> i & 1) != 0) result |= 1u << place(i);
    return result;
}

TEST(EdgePatterns, AreSymmetric) {
    const auto quarter_turn = [](uint32_t i) { return 3 * (i % 3) + 2 - i / 3; };
    const auto mirror = [](uint32_t i) { return 3 * (i / 3) + 2 - i % 3; };
    for (uint32_t k = 0; k < edge_pattern_count; ++k) {
        EXPECT_NEAR(patterns()[k], 1 - patterns()[edge_pattern_count - 1 - k], 1e-9);
        EXPECT_NEAR(patterns()[k], patterns()[moved(k, quarter_turn)], 1e-9);
        EXPECT_NEAR(patterns()[k], patterns()[moved(k, mirror)], 1e-9);
    }
}

TEST(EdgePatterns, AreProbabilities) {
    for (const double visibility : patterns()) {
        EXPECT_GE(visibility, 0);
        EXPECT_LE(visibility, 1);
    }
    EXPECT_EQ(patterns()[0], 0);  // umbra and light stay what they are
    EXPECT_EQ(patterns()[511], 1);
    EXPECT_EQ(edge_pattern_table().size(), size_t(edge_pattern_count));
}

// The part of a disc-shaped sun of diameter `width` that a straight edge leaves, by 64 chords.
double sun_beyond(double distance, double width) {
    double seen = 0, all = 0;
    for (int i = 0; i < 64; ++i) {
        const double x = (i + 0.5) / 32 - 1, chord = std::sqrt(1 - x * x);
        all += chord;
        seen += distance + x * width / 2 > 0 ? chord : 0;
    }
    return seen / all;
}

struct Errors {
    double ray = 0, pattern = 0;
};

// Summed squared errors; `strip_px`: how wide the light is, 0 for half a plane.
Errors errors_of(double width_px, double strip_px) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    Errors errors;
    for (int trial = 0; trial < 8000; ++trial) {
        const double angle = 2 * std::numbers::pi * unit(random), place = 7 * unit(random) - 3.5;
        uint32_t pattern = 0;
        double centre = 0;
        for (int i = 0; i < 9; ++i) {
            const double d = std::cos(angle) * (i % 3 - 1) + std::sin(angle) * (i / 3 - 1) + place;
            const double v =
                sun_beyond(d, width_px) - (strip_px > 0 ? sun_beyond(d - strip_px, width_px) : 0);
            if (i == 4) centre = v;
            if (unit(random) < v) pattern |= 1u << i;
        }
        const double ray = (pattern >> 4 & 1) - centre, by_pattern = patterns()[pattern] - centre;
        errors.ray += ray * ray;
        errors.pattern += by_pattern * by_pattern;
    }
    return errors;
}

TEST(EdgePatterns, KnowMoreThanTheRayInANarrowPenumbra) {
    for (const double width_px : {1.0, 2.0, 4.0}) {
        SCOPED_TRACE(width_px);
        const Errors edge = errors_of(width_px, 0), strip = errors_of(width_px, 2.5);
        EXPECT_LT(edge.pattern, 0.4 * edge.ray);
        EXPECT_LT(strip.pattern, 0.75 * strip.ray);
    }
}

}  // namespace
}  // namespace penumbra::test
