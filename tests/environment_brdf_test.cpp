// SPDX-License-Identifier: MIT
// The table of what rough mirrors reflect, against an integral over all directions that draws none by the
// lobe.
#include "nodes/tables/environment_brdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace penumbra::test {
namespace {

// Response of GGX with height-correlated masking, times cosine (Heitz 2014, "Understanding the
// Masking-Shadowing Function in Microfacet-Based BRDFs"), over the hemisphere of l in equal steps of angles.
EnvironmentBrdf over_the_hemisphere(double n_v, double roughness) {
    const double a2 = std::pow(roughness, 4), vx = std::sqrt(1 - n_v * n_v);
    const auto lambda = [&](double c) { return (std::sqrt(1 + a2 * (1 / (c * c) - 1)) - 1) / 2; };
    const int steps = 400;
    EnvironmentBrdf sum;
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j) {
            const double polar = (i + 0.5) / steps * std::numbers::pi / 2,
                         azimuth = (j + 0.5) / steps * std::numbers::pi;
            const double lz = std::cos(polar), lx = std::sin(polar) * std::cos(azimuth);
            const double length = std::sqrt(2 + 2 * (vx * lx + n_v * lz)), hz = (lz + n_v) / length,
                         v_h = length / 2;
            const double d = a2 / (std::numbers::pi * std::pow(hz * hz * (a2 - 1) + 1, 2));
            const double response = d / (4 * n_v * (1 + lambda(n_v) + lambda(lz)));
            const double solid =
                2 * std::sin(polar) * (std::numbers::pi / 2 / steps) * (std::numbers::pi / steps);
            sum.white += response * solid;
            sum.grazing += response * solid * std::pow(1 - v_h, 5);
        }
    return sum;
}

TEST(EnvironmentBrdf, IsTheIntegralOfTheResponse) {
    for (const double roughness : {0.3, 0.5, 0.8, 1.0})
        for (const double n_v : {0.1, 0.3, 0.7, 1.0}) {
            const EnvironmentBrdf expected = over_the_hemisphere(n_v, roughness),
                                  is = environment_brdf(n_v, roughness);
            EXPECT_NEAR(is.white, expected.white, 2e-3) << n_v << " " << roughness;
            EXPECT_NEAR(is.grazing, expected.grazing, 1e-3) << n_v << " " << roughness;
        }
}

TEST(EnvironmentBrdf, AMirrorReflectsAll) {
    for (const double n_v : {0.1, 0.5, 1.0}) {
        EXPECT_NEAR(environment_brdf(n_v, 0).white, 1, 1e-6);
        EXPECT_NEAR(environment_brdf(n_v, 0).grazing, std::pow(1 - n_v, 5), 1e-3);
    }
}

TEST(EnvironmentBrdf, TheTableBetweenItsTexelsIsRight) {
    const std::vector<float> table = environment_brdf_table();
    for (double roughness = 0.02; roughness < 1; roughness += 0.13)
        for (double n_v = 0.05; n_v <= 1; n_v += 0.073) {
            const EnvironmentBrdf expected = environment_brdf(n_v, roughness),
                                  is = look_up(table, n_v, roughness);
            EXPECT_NEAR(is.white, expected.white, 3e-3) << n_v << " " << roughness;
            EXPECT_NEAR(is.grazing, expected.grazing, 3e-3) << n_v << " " << roughness;
        }
}

}  // namespace
}  // namespace penumbra::test
