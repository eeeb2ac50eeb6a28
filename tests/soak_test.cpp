// SPDX-License-Identifier: MIT
// The first 2000 frames of the soak (scripts/soak.sh runs 100 000), and that its limits can be passed: the
// published denoiser's counts stall in five bits and its mean drifts.
#include "tests/soak.h"

#include <cstdio>

#include "tests/gpu_test.h"

namespace penumbra::test {
namespace {

Soak printed_soak(const SoakOptions& options) {
    const Soak result = soak(gpu(), options);
    for (const SoakWindow& w : result.windows)
        std::printf("%s from %u: N_eff %.1f, mean %.6f\n", options.pipeline.c_str(), w.first, w.n_eff,
                    w.mean);
    std::printf("%s: drift %.2g, N_eff kept %.3f +- %.3f, left after a jump %.4f (young %.4f)\n",
                options.pipeline.c_str(), result.drift(), result.n_eff_kept(), result.kept_noise(),
                result.left, result.left_of_young);
    return result;
}

class SoakRun : public GpuTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(SoakRun, LosesNothingIn2000Frames) {
    const Soak result = printed_soak({.pipeline = GetParam(), .frames = 2000});
    EXPECT_TRUE(soak_holds(result));
    EXPECT_LT(result.kept_noise(), 0.06) << "too noisy to say what is kept";
    EXPECT_GT(result.windows.front().n_eff, 50) << "no picture to lose anything of";
    EXPECT_LT(result.left, 0.1) << "the jump is not followed";
}

INSTANTIATE_TEST_SUITE_P(Pipelines, SoakRun, ::testing::Values("one_ray", "shadows_fast"),
                         [](const auto& test) { return std::string(test.param); });

class SoakLimits : public GpuTest {};

TEST_F(SoakLimits, ArePassedByThePublishedDenoiser) {
    EXPECT_FALSE(soak_holds(printed_soak({.pipeline = "fidelityfx", .frames = 1300})));
}

// Of seven windows, as 2000 frames have: what falls steadily is lost, what goes up and down is not.
TEST(SoakNoise, IsNoExcuseForWhatIsLost) {
    const auto run_of = [](std::initializer_list<double> n_eff) {
        Soak soak;
        for (const double n : n_eff) soak.windows.push_back({.n_eff = n, .mean = 0.5});
        return soak;
    };
    EXPECT_TRUE(soak_holds(run_of({109, 103, 103, 95, 95, 98, 98})));
    EXPECT_FALSE(soak_holds(run_of({109, 106, 103, 100, 97, 94, 91})));
    EXPECT_FALSE(soak_holds(run_of({109, 107.5, 106, 104.5, 103, 101.5, 100})));
}

}  // namespace
}  // namespace penumbra::test
