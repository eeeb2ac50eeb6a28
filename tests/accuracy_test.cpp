// SPDX-License-Identifier: MIT
// The published denoiser, through the whole pipeline on a device, on a shadow edge whose visibility is known
// exactly: it must score as the published form is known to, in effective samples per pixel. docs/accuracy.md
// has the table.
#include "host/metrics/metrics.h"
#include "host/truth/analytic.h"
#include "tests/gpu_test.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

constexpr uint32_t width = 192, height = 96, border = 24;

struct Case {
    double penumbra_px = 8, speed_px = 0;
    uint32_t frame = 64;  // that is measured
    uint32_t seeds = 8;
    std::vector<std::string> settings;
    std::string name = "fidelityfx";
};

Shot shot_of(const Case& c) {
    Shot shot;
    shot.analytic = AnalyticScene{c.penumbra_px, 20, c.speed_px, -c.speed_px * c.frame};
    shot.size = {width, height};
    shot.frames = c.frame + 1;
    shot.sun = {{0, {0.3, 0.2, 1}}};
    add_analytic_motion(shot);
    return shot;
}

MaskMetrics measure_case(const Case& c) {
    const Shot shot = shot_of(c);
    std::vector<std::vector<float>> images;
    for (uint32_t seed = 1; seed <= c.seeds; ++seed)
        images.push_back(ShotRun(c.name, shot, {.settings = c.settings, .seed = seed}).up_to(c.frame));
    const std::vector<float> truth = analytic_truth(shot, c.frame).visibility;
    std::vector<uint8_t> counted;  // what the published form does at the image's border is not in question
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            counted.push_back(x >= border && y >= border && x < width - border && y < height - border);
    ComparedFrame frame{width, height, truth, counted, {}};
    for (const std::vector<float>& image : images) frame.seeds.emplace_back(image);
    return metrics_of(measure(frame));
}

class Accuracy : public GpuTest {};

TEST_F(Accuracy, PublishedDenoiserScoresAsKnownWhereNothingMoves) {
    const struct { double penumbra_px, n_eff; } known[] = {{8, 34}, {16, 61}, {32, 70}};
    for (const auto& [penumbra_px, n_eff] : known) {
        Case c;
        c.penumbra_px = penumbra_px;
        const MaskMetrics m = measure_case(c);
        std::printf("static, %2.0f px: N_eff %.1f (known %.0f), bias part %.1f\n", penumbra_px,
                    m.n_eff.value(), n_eff, m.n_bias.value_or(0));
        EXPECT_NEAR(m.n_eff.value(), n_eff, 0.15 * n_eff) << penumbra_px;
        EXPECT_EQ(m.nonfinite, 0u);
    }
}

// The limit is the last pass's contrast, not the sampling and not the rest of the filter.
TEST_F(Accuracy, PublishedDenoiserIsHeldBackByItsContrast) {
    Case c;
    c.penumbra_px = 32;
    c.seeds = 4;
    c.settings = {"nodes.filter2.params.contrast=false"};
    EXPECT_GT(measure_case(c).n_eff.value(), 300);
}

// Known: at 32 px as for the static case; at 8 px by the model in double precision (tests/denoiser_model.h),
// which the older figures (3.9, 3.6, 1.7, 1.6) exceed by a third, while it agrees with them at 32 px.
TEST_F(Accuracy, PublishedDenoiserLagsAsKnownBehindAMovingEdge) {
    const struct {
        double penumbra_px, speed_px, n_eff;
    } known[] = {{8, 0.25, 3.1}, {8, 1, 2.4},  {8, -0.25, 1.4},  {8, -1, 1.24},
                 {32, 0.25, 18}, {32, 1, 7.2}, {32, -0.25, 4.6}, {32, -1, 2.9}};
    for (const auto& [penumbra_px, speed_px, n_eff] : known) {
        const double measured = measure_case({penumbra_px, speed_px, 48, 2, {}}).n_eff.value();
        std::printf("%+.2f px per frame, %2.0f px: N_eff %.2f (known %.2f)\n", speed_px, penumbra_px,
                    measured, n_eff);
        EXPECT_NEAR(measured, n_eff, 0.3 * n_eff) << penumbra_px << " px, " << speed_px;
    }
}

}  // namespace
}  // namespace penumbra::test
