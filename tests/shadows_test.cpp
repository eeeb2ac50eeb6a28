// SPDX-License-Identifier: MIT
// What one_ray.json and shadows.json promise, on a straight shadow edge that goes through the whole pipeline
// as real geometry: effective samples per pixel on the first frame, in the long run and behind a moving edge,
// at any angle (so the denoiser's sun is the tracer's); no worse than the ray anywhere; no trace of garbage
// or of the borders. Gates are about half of what is reached (docs/denoiser.md).
#include "tests/edge_run.h"

namespace penumbra::test {
namespace {

double n_eff(const Edge& edge, const char* pipeline = "one_ray") {
    return n_eff_inside(edge, ShotRun(pipeline, shot_of(edge), {.seed = 1}).up_to(edge.last));
}

class Shadows : public GpuTest {};

TEST_F(Shadows, ConvergeToTheTruth) {
    EXPECT_GT(n_eff({.width_px = 0.5}), 60);  // 2 where a young past is taken at its word
    EXPECT_GT(n_eff({.width_px = 1}), 60);
    EXPECT_GT(n_eff({.width_px = 2}), 100);    // 63 with a handful of neighbours' rays
    EXPECT_GT(n_eff({.width_px = 2.5}), 250);  // 215 by these alone
    EXPECT_GT(n_eff({.width_px = 8}), 5000);   // 2300 where a frame whose rays agree is certain of it
    EXPECT_GT(n_eff({.width_px = 16}), 5000);
    EXPECT_GT(n_eff({.width_px = 32}), 4000);
}

TEST_F(Shadows, StartWell) {
    EXPECT_GT(n_eff({.width_px = 1, .last = 0}), 1.7);  // by the patterns: the rays alone give 1.07
    EXPECT_GT(n_eff({.width_px = 1.5, .last = 0}), 2.5);
    EXPECT_GT(n_eff({.width_px = 2, .last = 0}),
              2.8);  // .99 where nobody asks before eight neighbours test the disc
    EXPECT_GT(n_eff({.width_px = 2.5, .last = 0}), 3);
    EXPECT_GT(n_eff({.width_px = 4, .last = 0}), 6);
    EXPECT_GT(n_eff({.width_px = 8, .last = 0}), 60);
    EXPECT_GT(n_eff({.width_px = 16, .last = 0}), 90);
    EXPECT_GT(n_eff({.width_px = 32, .last = 0}), 120);
}

// With the sun's axes mirrored or swapped between tracer and denoiser these fall to a few.
TEST_F(Shadows, StartWellAtAnyAngle) {
    for (const double angle : {0.0, 45.0, 70.0, 90.0, 110.0, 135.0, 160.0})
        EXPECT_GT(n_eff({.width_px = 8, .last = 0, .edge_deg = angle}), 40) << angle;
}

TEST_F(Shadows, FollowAMovingEdge) {
    for (const double speed : {-4.0, -0.5, 0.1, 0.5}) {
        SCOPED_TRACE(speed);
        EXPECT_GT(n_eff({.width_px = 1, .speed_px = speed, .last = 24}), 1.5);
        EXPECT_GT(n_eff({.width_px = 2, .speed_px = speed, .last = 24}), 2.8);
        EXPECT_GT(n_eff({.width_px = 4, .speed_px = speed, .last = 24}), 6);
        EXPECT_GT(n_eff({.width_px = 8, .speed_px = speed, .last = 24}), 40);
        EXPECT_GT(n_eff({.width_px = 32, .speed_px = speed, .last = 24}), 90);
    }
}

// The same edges under a budget of one ray per surface that looks at the sun: what surely lit and shadowed
// pixels do not need, the edge has.
TEST_F(Shadows, HaveMoreOfABudgetThanOfSingleRays) {
    EXPECT_GT(n_eff({.width_px = 1, .last = 0}, "shadows_best"), 60);
    EXPECT_GT(n_eff({.width_px = 8, .last = 0}, "shadows_best"), 150);
    for (const double speed : {-4.0, 0.5}) {
        SCOPED_TRACE(speed);
        EXPECT_GT(n_eff({.width_px = 1, .speed_px = speed, .last = 24}, "shadows_fast"), 4);
        EXPECT_GT(n_eff({.width_px = 1, .speed_px = speed, .last = 24}, "shadows_best"), 40);
        EXPECT_GT(n_eff({.width_px = 8, .speed_px = speed, .last = 24}, "shadows_best"), 120);
        EXPECT_GT(n_eff({.width_px = 32, .speed_px = speed, .last = 24}, "shadows_best"), 300);
    }
}

// As much as each pixel with a ray of its own has, which whatever makes the profile too steep or too flat for
// good ends: each ray counting alike, however many its pixel has; what is known without a ray as a test of
// the sun's middle; rounding taken for a past that is wrong; a frame of n rays counting more than n frames.
TEST_F(Shadows, HaveNoBiasWhereAnEdgeStandsStill) {
    for (const double width : {4.0, 8.0, 16.0}) {
        const double n = n_eff({.width_px = width}, "shadows_fast");
        std::printf("%g px: %.4g\n", width, n);
        EXPECT_GT(n, width == 4.0 ? 3000 : 5200) << width;
    }
}

// A past that an edge slowly leaves behind gets further rays, though it is of many frames: with few the drift
// test is slow to see that it is over.
TEST_F(Shadows, SpendRaysOnAPastThatIsSlowlyLeftBehind) {
    double mean = 0;
    for (const double speed : {-0.1, 0.1})
        for (const uint32_t seed : {0u, 1u}) {
            const Edge edge{.width_px = 16, .speed_px = speed, .last = 39};
            mean += 0.25 * n_eff_inside(
                               edge, ShotRun("shadows_best", shot_of(edge), {.seed = seed}).up_to(edge.last));
        }
    std::printf("%.4g\n", mean);
    EXPECT_GT(mean, 550);
}

// A first frame is softened by a part of the penumbra at every width.
TEST_F(Shadows, AreSoftenedBelowARadiusOfFourPixels) {
    double mean = 0;
    for (const uint32_t seed : {0u, 1u, 2u, 3u}) {
        const Edge edge{.width_px = 6.5, .last = 0};
        mean += 0.25 * n_eff_inside(edge, ShotRun("one_ray", shot_of(edge), {.seed = seed}).up_to(0));
    }
    std::printf("%.4g\n", mean);
    EXPECT_GT(mean, 55);
}

TEST_F(Shadows, AreAsGoodAtTheBordersAsInside) {
    const Edge edge{.width_px = 32, .last = 31};
    const std::vector<float> image = ShotRun("shadows_fast", shot_of(edge), {.seed = 3}).up_to(edge.last);
    const auto border = [&](size_t i) {
        return i / edge.size[0] < 8 || i / edge.size[0] >= edge.size[1] - 8;
    };
    const auto inside = [&](size_t i) { return !border(i); };
    EXPECT_GT(test::n_eff(image, truth_of(edge), border), 0.3 * test::n_eff(image, truth_of(edge), inside));
}

TEST_F(Shadows, AreExactWhereNothingIsUncertain) {
    for (const double offset : {-400.0, 400.0}) {
        const Edge edge{.width_px = 8, .last = 3, .offset_px = offset, .size = {203, 61}};
        const std::vector<float> image = ShotRun("shadows_fast", shot_of(edge)).up_to(3);
        for (const float v : image) ASSERT_EQ(v, offset < 0 ? 1.0f : 0.0f);
    }
}

TEST_F(Shadows, ForgetEverythingOnAReset) {
    const Edge edge{.width_px = 16, .speed_px = 1, .last = 8};
    ShotRun warm("shadows_fast", shot_of(edge)), cold("shadows_fast", shot_of(edge));
    warm.up_to(7);
    EXPECT_TRUE(warm.frame(8, true) == cold.frame(8, true));
}

// A first frame without the reset flag reads what the memory happens to hold.
TEST_F(Shadows, TakeGarbageForNoHistory) {
    const Edge edge{.width_px = 16, .last = 4};
    ShotRun clean("shadows_fast", shot_of(edge), {.poison = 0}),
        poisoned("shadows_fast", shot_of(edge), {.poison = 1});
    for (uint32_t index = 0; index <= edge.last; ++index) {
        SCOPED_TRACE(index);
        EXPECT_TRUE(clean.frame(index, index == 0) == poisoned.frame(index, false));
    }
}

}  // namespace
}  // namespace penumbra::test
