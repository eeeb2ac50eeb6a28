// SPDX-License-Identifier: MIT
// What docs/coverage.md says of the table of half-planes beyond single edges (light_samples_test): what a
// right angle, a wire and a corner of several triangles cost.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "host/truth/coverage.h"

namespace penumbra::test {
namespace {

using std::numbers::pi;

constexpr double angular_radius = 1e-3;  // small: no cap to speak of

class CoverageTable : public ::testing::TestWithParam<uint32_t> {
  protected:
    // Where n . p + c >= 0 on the unit disc, n at this angle.
    SampleMask side(double angle, double c, double dither) const {
        const double tangent = std::tan(angular_radius);
        return sun_.positive_side({std::cos(angle) / tangent, std::sin(angle) / tangent, c}, angular_radius,
                                  dither);
    }
    double uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }

    const uint32_t count_ = GetParam();
    const SampledSun sun_{GetParam()};
    std::mt19937 random_{1};
};

// A right angle pays for the place of its corner among the samples, and stays unbiased.
TEST_P(CoverageTable, ARightAngleIsOffByLessThanASampleAsARule) {
    constexpr int corners = 4000, strips = 400;
    double sum = 0, squares = 0;
    for (int i = 0; i < corners; ++i) {
        const double angle = 2 * pi * uniform(), c1 = 1.6 * uniform() - 0.8, c2 = 1.6 * uniform() - 0.8,
                     dither = uniform();
        double area = 0;  // x >= -c1 and y >= -c2
        for (int s = 0; s < strips; ++s) {
            const double x = -c1 + (1 + c1) * (s + 0.5) / strips, h = std::sqrt(std::max(1 - x * x, 0.0));
            area += std::max(h - std::max(-c2, -h), 0.0) * (1 + c1) / strips / pi;
        }
        const SampleMask both = side(angle, c1, dither) & side(angle + pi / 2, c2, dither);
        const double error = static_cast<double>(both.count()) / count_ - area;
        sum += error;
        squares += error * error;
    }
    EXPECT_LT(std::sqrt(squares / corners), 0.9 / count_);
    EXPECT_LT(std::abs(sum / corners), 0.05 / count_);
}

// Both sides of a wire are rounded by one dither: it hides a sample as often as its area asks for.
TEST_P(CoverageTable, AThinWireIsRightOnAverage) {
    constexpr int wires = 100000;
    const double width = 0.3 / count_;
    double hidden = 0, area = 0;
    for (int i = 0; i < wires; ++i) {
        const double angle = 2 * pi * uniform(), c = 1.6 * uniform() - 0.8, dither = uniform();
        const SampleMask wire = side(angle, c, dither) & side(angle + pi, width - c, dither);
        ASSERT_LE(wire.count(), 1u);
        hidden += static_cast<double>(wire.count());
        area += (half_disc_area(c) - half_disc_area(c - width)) * count_;
    }
    EXPECT_NEAR(hidden / area, 1, 0.03);
}

// Rounded lines through one corner need not meet: of a closed fan of triangles around it a sample can be
// left, seldom and never many.
TEST_P(CoverageTable, AFanAroundACornerSeldomLeavesASample) {
    constexpr int fans = 10000;
    for (const int triangles : {3, 5, 6}) {
        int open = 0;
        size_t left = 0;
        for (int i = 0; i < fans; ++i) {
            const double r = std::sqrt(uniform()), at = 2 * pi * uniform(), first = 2 * pi * uniform(),
                         dither = uniform();
            const double x = r * std::cos(at), y = r * std::sin(at);
            std::vector<SampleMask> spokes;
            for (int k = 0; k < triangles; ++k) {
                const double angle = first + 2 * pi * (k + 0.5 * uniform()) / triangles + pi / 2;
                spokes.push_back(side(angle, -(std::cos(angle) * x + std::sin(angle) * y), dither));
            }
            SampleMask covered;
            for (size_t k = 0; k < spokes.size(); ++k)
                covered |= spokes[k] & ~spokes[(k + 1) % spokes.size()];
            const size_t missed = count_ - covered.count();
            open += missed > 0;
            left = std::max(left, missed);
        }
        EXPECT_LT(open, fans * (triangles == 3 ? 0.035 : 0.005)) << triangles;
        EXPECT_LE(left, 2u) << triangles;
    }
}

INSTANTIATE_TEST_SUITE_P(Samples, CoverageTable, ::testing::ValuesIn(light_sample_counts));

}  // namespace
}  // namespace penumbra::test
