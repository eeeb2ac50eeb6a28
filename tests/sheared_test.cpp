// SPDX-License-Identifier: MIT
// What sheared.json promises, on a straight shadow edge that goes through the whole pipeline as real
// geometry: effective samples per pixel on the first frame, in the long run and behind a moving edge, at any
// angle (so the denoiser's sun is the tracer's); no worse than the ray anywhere; no trace of garbage or of
// the borders. Gates are about half of what is reached (docs/sheared.md).
#include "tests/edge_run.h"

namespace penumbra::test {
namespace {

double n_eff(const Edge& edge, uint32_t seed = 1) {
    return n_eff_inside(edge, EdgeRun(edge, "sheared", seed).up_to(edge.last));
}

class Sheared : public GpuTest {};

TEST_F(Sheared, ConvergesToTheTruth) {
    EXPECT_GT(n_eff({.width_px = 0.5}), 60);  // 2 where a young past is taken at its word
    EXPECT_GT(n_eff({.width_px = 1}), 60);
    EXPECT_GT(n_eff({.width_px = 2}), 100);  // 63 with a handful of neighbours' rays
    EXPECT_GT(n_eff({.width_px = 8}), 400);
    EXPECT_GT(n_eff({.width_px = 16}), 800);
    EXPECT_GT(n_eff({.width_px = 32}), 1200);
}

TEST_F(Sheared, StartsWell) {
    EXPECT_GT(n_eff({.width_px = 1, .last = 0}), 1.7);  // by the patterns: the rays alone give 1.07
    for (const double width : {2.0, 4.0}) EXPECT_GT(n_eff({.width_px = width, .last = 0}), 0.95) << width;
    EXPECT_GT(n_eff({.width_px = 8, .last = 0}), 60);
    EXPECT_GT(n_eff({.width_px = 16, .last = 0}), 90);
    EXPECT_GT(n_eff({.width_px = 32, .last = 0}), 120);
}

// With the sun's axes mirrored or swapped between tracer and denoiser these fall to a few.
TEST_F(Sheared, StartsWellAtAnyAngle) {
    for (const double angle : {0.0, 45.0, 70.0, 90.0, 110.0, 135.0, 160.0})
        EXPECT_GT(n_eff({.width_px = 8, .last = 0, .edge_deg = angle}), 40) << angle;
}

TEST_F(Sheared, FollowsAMovingEdge) {
    for (const double speed : {-4.0, 0.1, 0.5}) {
        SCOPED_TRACE(speed);
        EXPECT_GT(n_eff({.width_px = 1, .speed_px = speed, .last = 24}), 1.5);
        EXPECT_GT(n_eff({.width_px = 8, .speed_px = speed, .last = 24}), 40);
        EXPECT_GT(n_eff({.width_px = 32, .speed_px = speed, .last = 24}), 90);
    }
}

TEST_F(Sheared, IsAsGoodAtTheBordersAsInside) {
    const Edge edge{.width_px = 32, .last = 31};
    const std::vector<float> image = EdgeRun(edge, "sheared", 3).up_to(edge.last);
    const auto border = [&](int, int y) { return y < 8 || y >= int(edge.size[1]) - 8; };
    const auto inside = [&](int x, int y) { return !border(x, y); };
    EXPECT_GT(n_eff(edge, image, border), 0.3 * n_eff(edge, image, inside));
}

TEST_F(Sheared, IsExactWhereNothingIsUncertain) {
    for (const double offset : {-400.0, 400.0}) {
        const std::vector<float> image =
            EdgeRun({.width_px = 8, .last = 3, .offset_px = offset, .size = {203, 61}}, "sheared").up_to(3);
        for (const float v : image) ASSERT_EQ(v, offset < 0 ? 1.0f : 0.0f);
    }
}

TEST_F(Sheared, ForgetsEverythingOnAReset) {
    const Edge edge{.width_px = 16, .speed_px = 1, .last = 8};
    EdgeRun warm(edge, "sheared"), cold(edge, "sheared");
    warm.up_to(7);
    EXPECT_TRUE(warm.frame(8, true) == cold.frame(8, true));
}

// A first frame without the reset flag reads what the memory happens to hold.
TEST_F(Sheared, TakesGarbageForNoHistory) {
    const Edge edge{.width_px = 16, .last = 4};
    EdgeRun clean(edge, "sheared", 0, 0u), poisoned(edge, "sheared", 0, 1u);
    for (uint32_t index = 0; index <= edge.last; ++index) {
        SCOPED_TRACE(index);
        EXPECT_TRUE(clean.frame(index, index == 0) == poisoned.frame(index, false));
    }
}

}  // namespace
}  // namespace penumbra::test
