// SPDX-License-Identifier: MIT
// Hard cases 26 to 29: suns on every axis, on the horizon, without an extent, and far too large.
#include <cmath>
#include <glm/gtc/type_ptr.hpp>

#include "host/truth/analytic.h"
#include "tests/hard_cases/hard_cases.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

// ---- 26: axes

// The frame around a direction as a camera's is made, from a fixed "up".
bool naive_frame_is_finite(const glm::vec3& d) {
    const glm::vec3 x = glm::normalize(glm::cross(glm::vec3(0, 1, 0), d));
    return std::isfinite(x.x) && std::isfinite(x.y) && std::isfinite(x.z);
}

Shot under(const glm::dvec3& to_sun, std::array<uint32_t, 2> size = {96, 64}) {
    Shot shot = plaza_shot(size, 4);
    shot.camera.resize(1);
    shot.objects.clear();
    shot.sun = {{0, to_sun}};
    return shot;
}

TEST_F(HardCase, ASunOnAnAxisIsASunLikeAnyOther) {
    const double ulp = 0x1p-24;
    size_t naive = 0, suns = 0;
    double worst_step = 0;
    for (const glm::dvec3& axis : {glm::dvec3(0, 1, 0), {1, 0, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, -1}})
        for (const glm::dvec3& off : {glm::dvec3(0), {ulp, 0, 0}, {0, -ulp, 0}, {0, 0, -ulp}}) {
            ++suns;
            naive += !naive_frame_is_finite(glm::vec3(axis + off));
            ShotRun run("shadows_fast", under(axis + off), {.captures = {"color"}});
            EXPECT_EQ(nonfinite(run.up_to(1)), 0u);
            EXPECT_EQ(nonfinite(run.plane("color")), 0u);
        }
    // The picture is a continuous function of the direction: whatever frame the samples are taken in, they
    // converge. Two sets of n stratified rays differ by n^-3/4 where the frame turns, at z = 0: 6e-4 for
    // 1024.
    constexpr uint32_t rays = 16'384;
    for (const glm::dvec3& axis : {glm::dvec3(0, 1, 0), {1, 0.6, 0}}) {
        const std::vector<float> at = truth_of(under(axis, {48, 32}), 0, rays).visibility;
        for (const glm::dvec3& step : {glm::dvec3(0, 0, 1e-6), {0, 0, -1e-6}})
            worst_step =
                std::max(worst_step, rms(at, truth_of(under(axis + step, {48, 32}), 0, rays).visibility));
    }
    figure("case 26, suns without a frame of 20 (naive); RMS of a step of 1e-6 rad (ours)", double(naive),
           worst_step);
    EXPECT_GT(naive, 0u);
    EXPECT_LT(worst_step, 1e-4);
}

// ---- 27: the horizon

double mean_of(const std::vector<float>& values) {
    double sum = 0;
    for (const float v : values) sum += v;
    return sum / static_cast<double>(values.size());
}

TEST_F(HardCase, ASettingSunIsCutByTheHorizonExactly) {
    const double radius_deg = 5;
    double naive = 0, ours = 0;
    for (const double elevation_deg : {-5.5, -4.0, -2.0, -0.5, 0.0, 1.0, 3.0, 4.5}) {
        Shot shot = scene_shot("floor", {{"floor", ground(4000, 4000, 1, 1)}}, {64, 48});
        shot.sun = {
            {0, {std::cos(glm::radians(elevation_deg)), std::sin(glm::radians(elevation_deg)), 1e-3}}};
        shot.sun_angular_radius_deg = radius_deg;
        const double exact = half_plane_visibility(glm::radians(elevation_deg), glm::radians(radius_deg));
        ours = std::max(ours, std::abs(mean_of(ShotRun("raw", shot).mean(64)) - exact));
        const RunOptions centre{.settings = {"nodes.classify.params.terminator=centre"}};
        naive = std::max(naive, std::abs(mean_of(ShotRun("raw", shot, centre).mean(64)) - exact));
    }
    figure("case 27, error of the visibility under a setting sun", naive, ours);
    EXPECT_LT(ours, 1e-3);
    EXPECT_GT(naive, 0.2);
}

// ---- 28: hardly a disc

TEST_F(HardCase, ASunOfATenthOfAMicroradianCastsTheHardShadow) {
    Shot disc = plaza_shot({160, 96}, 8), point = plaza_shot({160, 96}, 8);
    disc.sun_angular_radius_deg = glm::degrees(1e-7);
    point.sun_angular_radius_deg = 0;
    ShotRun raw("raw", disc), hard("raw", point), soft("shadows_fast", disc);
    size_t differ = 0, blurred = 0, pixels = 0;
    for (uint32_t frame = 0; frame < 8; ++frame) {
        const std::vector<float> a = raw.frame(frame, frame == 0), b = hard.frame(frame, frame == 0),
                                 c = soft.frame(frame, frame == 0);
        EXPECT_EQ(nonfinite(a) + nonfinite(c), 0u);
        for (size_t i = 0; i < a.size(); ++i) {
            ++pixels;
            differ += a[i] != b[i];
            blurred += frame == 7 && std::abs(c[i] - b[i]) > 0.5;
        }
    }
    // The concentric map's quotient at the middle of the square, as it is usually written.
    const float zero = 0;
    figure("case 28, value at the middle of the disc (naive); share of rays unlike the hard ones (ours)",
           double(zero / zero), double(differ) / double(pixels));
    EXPECT_LT(differ, pixels / 10'000);
    EXPECT_LT(blurred, 160u * 96 / 500);
}

// ---- 29: far too large

TEST_F(HardCase, AWideSunIsAsBrightAsItsCap) {
    for (const double radius_deg : {10.0, 45.0}) {
        Shot shot;
        shot.analytic = AnalyticScene{.penumbra_px = 48, .edge_deg = 17};
        shot.size = {96, 64};
        shot.frames = 64;
        shot.sun = {{0, {0.05, 0.02, 1}}};
        shot.sun_angular_radius_deg = radius_deg;
        const std::vector<float> truth = analytic_truth(shot, 0).visibility;
        const auto bias = [&](const RunOptions& options) {
            const std::vector<float> mean = ShotRun("raw", shot, options).mean(64);
            // Along the edge's normal the errors of the two sides cancel; a box of 9x9 pixels keeps what does
            // not.
            double worst = 0;
            for (size_t y = 4; y + 4 < 64; y += 4)
                for (size_t x = 4; x + 4 < 96; x += 4) {
                    double sum = 0;
                    for (size_t v = y - 4; v <= y + 4; ++v)
                        for (size_t u = x - 4; u <= x + 4; ++u) sum += mean[v * 96 + u] - truth[v * 96 + u];
                    worst = std::max(worst, std::abs(sum / 81));
                }
            return worst;
        };
        const double ours = bias({}), naive = bias({.settings = {"nodes.trace.params.sampling=published"}});
        figure(("case 29, largest bias of 9x9 pixels after 64 rays, radius in degrees " +
                std::to_string(radius_deg))
                   .c_str(),
               naive, ours);
        EXPECT_LT(ours, 0.01);
        EXPECT_GT(naive, 2 * ours);
        Shot few = shot;
        few.size = {24, 16};
        few.analytic->penumbra_px = 12;
        const std::vector<float> exact = analytic_truth(few, 0).visibility,
                                 counted = truth_of(few, 0, 65'536).visibility;
        double largest = 0;
        for (size_t i = 0; i < exact.size(); ++i)
            largest = std::max(largest, std::abs(double(counted[i]) - exact[i]));
        figure("case 29, largest error and rms of 65 536 rays in a pixel (naive: rms)", rms(counted, exact),
               largest);
        EXPECT_LT(largest, 1e-3);
        EXPECT_LT(rms(counted, exact), 2e-4);
    }
}

}  // namespace
}  // namespace penumbra::test
