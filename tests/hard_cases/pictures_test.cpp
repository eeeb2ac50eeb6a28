// SPDX-License-Identifier: MIT
// Hard cases 52 to 54: no contrast added, no steps, and a penumbra as bright as it is under a bright sun. The
// naive forms are the published denoiser (fidelityfx.json), 8 bits, and anti-aliasing of the noise itself.
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "host/truth/analytic.h"
#include "tests/hard_cases/hard_cases.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

// ---- 52, 54: what a picture is made of

double largest_bias(const std::vector<float>& mean, const std::vector<float>& truth, size_t width,
                    size_t height) {
    double worst = 0;
    for (size_t y = 4; y + 4 < height; ++y)
        for (size_t x = 4; x + 4 < width; ++x) {
            double sum = 0;
            for (size_t v = y - 4; v <= y + 4; ++v)
                for (size_t u = x - 4; u <= x + 4; ++u) sum += mean[v * width + u] - truth[v * width + u];
            worst = std::max(worst, std::abs(sum / 81));
        }
    return worst;
}

TEST_F(HardCase, NoContrastIsAdded) {
    const Shot shot = edge_shot(32, 17, {96, 64}, 48);
    const std::vector<float> truth = analytic_truth(shot, 0).visibility;
    const auto bias = [&](const char* pipeline) {
        std::vector<float> mean(truth.size(), 0);
        for (const uint32_t seed : {1u, 2u, 3u, 4u}) {  // one is a quarter as sure
            ShotRun run(pipeline, shot, {.seed = seed});
            const std::vector<float> v = run.up_to(31);
            for (size_t i = 0; i < v.size(); ++i) mean[i] += v[i] / 4;
        }
        return largest_bias(mean, truth, 96, 64);
    };
    const double naive = bias("fidelityfx"), ours = bias("shadows_fast");
    figure("case 52, largest bias of 9x9 pixels, frame 31, mean of 4 seeds", naive, ours);
    EXPECT_LT(ours, 0.01);
    EXPECT_GT(naive, 0.04);
}

TEST_F(HardCase, AShadowSeenEightStopsUpHasNoSteps) {
    const Shot shot = edge_shot(64, 17, {96, 64}, 32);
    const auto step = [&](const char* format) {
        const RunOptions options{.settings = {std::string("resources.visibility.format=") + format}};
        const std::vector<float> v = ShotRun("shadows_fast", shot, options).up_to(31);
        std::set<float> dark;  // the part that is seen at + 8 stops
        for (const float x : v)
            if (x < 0.125f) dark.insert(x);
        EXPECT_GE(dark.size(), 32u);  // all that r8 has
        std::vector<double> gaps;
        for (float before = 0; const float x : dark) gaps.push_back(x - std::exchange(before, x));
        std::ranges::sort(gaps);
        return gaps.empty() ? 1 : gaps[gaps.size() * 19 / 20];
    };
    const double naive = step("r8"), ours = step("r16f");
    figure("case 54, widest of 95 % of the steps between shades below 1/8", naive, ours);
    EXPECT_LE(ours, 1.0 / 1024);
    EXPECT_GT(naive, 1.0 / 300);
}

// ---- 53: a sun 256 times as bright as the sky

TEST_F(HardCase, ABrightSunsPenumbraIsAsBrightAsItIs) {
    const Shot shot = edge_shot(32, 17, {96, 64}, 40);
    const std::vector<float> truth = analytic_truth(shot, 0).visibility;
    const std::vector<std::string> bright = {"nodes.shade.params.sun_color=[256, 256, 256]",
                                             "nodes.shade.params.ambient=[1, 1, 1]"};
    const auto error = [&](std::vector<std::string> more) {
        RunOptions options{.settings = bright, .captures = {"color", "lit"}};
        options.settings.insert(options.settings.end(), more.begin(), more.end());
        ShotRun run("shadows_fast", shot, options);
        std::vector<double> mean(truth.size(), 0);
        for (uint32_t frame = 0; frame < 40; ++frame) {
            run.frame(frame, frame == 0);
            const std::vector<float> color = run.plane("color");
            if (frame >= 24)
                for (size_t i = 0; i < color.size(); ++i) mean[i] += color[i] / 16.0;
        }
        // Lit is the brightest there is; the ambient light of a white surface is 1.
        const std::vector<float> lit = run.plane("lit");
        const double top = *std::ranges::max_element(lit), bottom = *std::ranges::min_element(lit);
        double sum = 0, expected = 0;
        for (size_t i = 0; i < truth.size(); ++i)
            if (truth[i] > 0.02 && truth[i] < 0.98) {
                sum += mean[i] - bottom;
                expected += truth[i] * (top - bottom);
            }
        return std::abs(sum / expected - 1);
    };
    // Naive: the noisy rays are shaded, and anti-aliasing averages them after c / (1 + c).
    const double naive = error({"nodes.soften=null", "nodes.hard.if=sun_up & casters"});
    const double ours = error({});
    figure("case 53, error of a penumbra's brightness under a sun of 256 times the sky", naive, ours);
    EXPECT_LT(ours, 0.02);
    EXPECT_GT(naive, 0.1);
}

}  // namespace
}  // namespace penumbra::test
