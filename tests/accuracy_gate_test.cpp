// SPDX-License-Identifier: MIT
// A gate against losing accuracy: small analytic shots through whole pipelines, with fixed seeds, and the
// effective samples per pixel that they have reached. Docs: docs/accuracy.md has the full tables.
#include <algorithm>
#include <cmath>

#include "app/gates/gates.h"
#include "host/metrics/mask_error.h"
#include "host/truth/analytic.h"
#include "tests/gpu_test.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

constexpr uint32_t width = 96, height = 64, border = 12, last_frame = 15, seeds = 2;

struct GateCase {
    const char* pipeline;
    const char* scene_name;
    AnalyticScene scene;
    double low, high;  // of N_eff: a fifth about what it is; other seeds move it by a tenth
};
// What ctest shows of a case.
void PrintTo(const GateCase& c, std::ostream* out) {
    *out << c.pipeline << ", " << c.scene_name;
}

Shot shot_of(const AnalyticScene& scene) {
    Shot shot;
    shot.analytic = scene;
    shot.analytic->offset_px -= scene.speed_px * last_frame;
    shot.size = {width, height};
    shot.frames = last_frame + 1;
    shot.sun_angular_radius_deg = 2;
    shot.sun = {{0, {0.3, 0.2, 1}}};
    add_analytic_motion(shot);
    return shot;
}

class Gates : public GpuTest {};
class AccuracyGate : public GpuTest, public ::testing::WithParamInterface<GateCase> {};

TEST_P(AccuracyGate, EffectiveSamplesAreKept) {
    const GateCase& c = GetParam();
    const Shot shot = shot_of(c.scene);
    ASSERT_FALSE(analytic_problem(shot, 0)) << analytic_problem(shot, 0)->text;
    std::vector<std::vector<float>> images;
    for (uint32_t seed = 1; seed <= seeds; ++seed)
        images.push_back(ShotRun(c.pipeline, shot, {.seed = seed}).up_to(last_frame));

    const std::vector<float> truth = analytic_truth(shot, last_frame).visibility;
    std::vector<uint8_t> counted = analytic_receivers(shot, last_frame);
    for (size_t p = 0; p < counted.size(); ++p) {
        const size_t x = p % width, y = p / width;
        if (x < border || y < border || x + border >= width || y + border >= height) counted[p] = 0;
    }
    const MaskMetrics m = metrics_of(measure({width, height, truth, counted, {images[0], images[1]}}));
    std::printf("%s, %s: N_eff %.2f, penumbra alone %.2f, %llu pixels of it\n", c.pipeline, c.scene_name,
                m.n_eff.value(), m.n_eff_penumbra.value(), static_cast<unsigned long long>(m.penumbra));
    EXPECT_GE(m.n_eff.value(), c.low);
    EXPECT_LE(m.n_eff.value(), c.high);
    EXPECT_EQ(m.nonfinite, 0u);
}

// What `penumbra gates` says of rays that nobody averages is known beforehand: one sample, white in time. On
// a tilted receiver this holds only where the closed form, the camera and the sheet agree.

TEST_F(Gates, ReadOneSampleOfOneRay) {
    const CheckedPipeline raw = shipped_pipeline("raw");
    gates::Study study;
    study.size = {width, height};
    study.border_px = border;
    study.seeds = 2;
    study.still_frames = 12;
    study.flicker_from = 2;
    study.speeds_px = {1};
    study.moving_frame = 8;
    study.tilted_edges_deg = {17, 90};
    study.tilted_seeds = 2;
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const gates::Bench bench{gpu(), shipped_nodes(), raw, study, [] {}, diagnostics, warnings};
    const auto still = gates::measure_still(bench, 16);
    const auto moving = gates::measure_moving(bench, 16);
    const auto tilted = gates::measure_tilted(bench, 16, 75);
    ASSERT_TRUE(still && moving && tilted) << diagnostics.text();
    EXPECT_NEAR(still->first.median, 1, 0.1);
    EXPECT_NEAR(still->last.median, 1, 0.1);
    EXPECT_NEAR(moving->front().n_eff.median, 1, 0.1);
    EXPECT_NEAR(tilted->mean, 1, 0.1);
    EXPECT_NEAR(tilted->worst, 1, 0.1);
    EXPECT_NEAR(still->flicker.median / 255, std::sqrt(2 * 0.144),
                0.15);  // consecutive samples repel each other
    EXPECT_LT(still->flicker_all.median, still->flicker.median);
}

std::string scene_of(const ::testing::TestParamInfo<GateCase>& info) {
    return info.param.scene_name;
}

constexpr double any = 1e9;  // ours may get better: its lower ends are a fifth below what it reaches
const AnalyticScene edge{16, 20, 0, 0, HalfPlane{}}, moving_edge{16, 20, 0.5, 0, HalfPlane{}},
    slit{12, 65, 0, 0, Slit{8}}, fence{16, 110, 0, 0, Fence{24, 0.5}}, ball{10, 0, 0, 0, Sphere{14}},
    wall{0, 20, 0, 8, ContactWall{1.5}};

INSTANTIATE_TEST_SUITE_P(Raw, AccuracyGate,
                         ::testing::Values(GateCase{"raw", "edge", edge, 0.9, 1.1},
                                           GateCase{"raw", "slit", slit, 0.9, 1.1},
                                           GateCase{"raw", "fence", fence, 0.9, 1.1},
                                           GateCase{"raw", "sphere", ball, 0.9, 1.1},
                                           GateCase{"raw", "wall", wall, 0.9, 1.1}),
                         scene_of);
INSTANTIATE_TEST_SUITE_P(Published, AccuracyGate,
                         ::testing::Values(GateCase{"fidelityfx", "edge", edge, 44, 67},
                                           GateCase{"fidelityfx", "moving_edge", moving_edge, 5.2, 7.9},
                                           GateCase{"fidelityfx", "sphere", ball, 56, 85}),
                         scene_of);
INSTANTIATE_TEST_SUITE_P(Sigma, AccuracyGate,
                         ::testing::Values(GateCase{"sigma", "edge", edge, 153, 230},
                                           GateCase{"sigma", "moving_edge", moving_edge, 5.9, 8.9},
                                           GateCase{"sigma", "sphere", ball, 72, 108}),
                         scene_of);
INSTANTIATE_TEST_SUITE_P(OneRay, AccuracyGate,
                         ::testing::Values(GateCase{"one_ray", "edge", edge, 1830, any},
                                           GateCase{"one_ray", "moving_edge", moving_edge, 155, any},
                                           GateCase{"one_ray", "slit", slit, 1870, any},
                                           GateCase{"one_ray", "fence", fence, 2100, any},
                                           GateCase{"one_ray", "sphere", ball, 1340, any},
                                           GateCase{"one_ray", "wall", wall, 88, any}),
                         scene_of);
INSTANTIATE_TEST_SUITE_P(Ours, AccuracyGate,
                         ::testing::Values(GateCase{"shadows_fast", "edge", edge, 1830, any},
                                           GateCase{"shadows_fast", "moving_edge", moving_edge, 155, any},
                                           GateCase{"shadows_fast", "slit", slit, 1470, any},
                                           GateCase{"shadows_fast", "fence", fence, 2100, any},
                                           GateCase{"shadows_fast", "sphere", ball, 1340, any},
                                           GateCase{"shadows_fast", "wall", wall, 88, any}),
                         scene_of);

}  // namespace
}  // namespace penumbra::test
