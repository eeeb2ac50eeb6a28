// SPDX-License-Identifier: MIT
// Metrics of what happens between frames: flicker and lag, on sequences whose answer is known beforehand.
#include <gtest/gtest.h>

#include <cmath>

#include "host/metrics/metrics.h"
#include "tests/penumbra_images.h"

namespace penumbra::test {
namespace {

// G-buffers of a plane at 10 m that moves in the image by whole or broken pixels.
struct Motion {
    std::vector<float> x, y, change, depth;

    Motion(const PenumbraImages& scene, double previous_x_px)
        : x(scene.truth.size(), static_cast<float>(previous_x_px / scene.width)),
          y(scene.truth.size(), 0),
          change(scene.truth.size(), 0),
          depth(scene.truth.size(), 10) {}
    FlickerSums step(const PenumbraImages& now, const PenumbraImages& before, FlickerSums sums = {}) const {
        const ComparedFrame a = now.frame(), b = before.frame();
        add_flicker({a, b, x, y, change, depth, depth}, sums);
        return sums;
    }
};

TEST(Flicker, AlternatingErrorIsTwiceItsSize) {
    PenumbraImages even, odd;
    even.add_images(1, [](double v, auto&) { return v + 0.02; });
    odd.add_images(1, [](double v, auto&) { return v - 0.02; });
    const Motion still(even, 0);
    FlickerSums sums = still.step(odd, even);
    sums = still.step(even, odd, sums);
    EXPECT_NEAR(sums.rms().value(), 0.04, 1e-6);
    EXPECT_NEAR(sums.p99().value(), 0.04, 1e-6);
    EXPECT_NEAR(still.step(even, even).rms().value(), 0, 1e-12);  // a constant error does not flicker
}

// Independent frames of one ray each: sqrt(2 v (1 - v)).
TEST(Flicker, OfWhiteNoiseIsItsSpreadTimesTheRootOfTwo) {
    PenumbraImages now, before;
    now.add_rays(8, 1);
    before.add_rays(9, 1);
    before.images.erase(before.images.begin());  // other seeds
    double variance = 0;
    for (const float v : now.truth) variance += static_cast<double>(v) * (1 - static_cast<double>(v));
    variance /= static_cast<double>(now.truth.size());
    PenumbraImages shuffled = before;
    EXPECT_NEAR(Motion(now, 0).step(shuffled, now).rms().value(), std::sqrt(2 * variance), 0.01);
}

// A moving shadow changes the image as it changes the truth: no flicker.
TEST(Flicker, WhatTheTruthDoesIsNotCharged) {
    PenumbraImages now(16, 3), before(16, 0);
    now.images = {now.truth};
    before.images = {before.truth};
    EXPECT_NEAR(Motion(now, 0).step(now, before).rms().value(), 0, 1e-7);
    before.images[0].assign(before.truth.size(), 0.5f);
    EXPECT_GT(Motion(now, 0).step(now, before).rms().value(), 0.3);
}

// The camera moves by 5.5 pixels over a scene with a noisy texture of errors that sticks to the surface:
// compensated, nothing flickers but what interpolation smooths; without it, everything would.
TEST(Flicker, ErrorsThatMoveWithTheSurfaceDoNotFlicker) {
    const auto image = [](double shift) {
        PenumbraImages scene;
        for (uint32_t y = 0; y < scene.height; ++y)
            for (uint32_t x = 0; x < scene.width; ++x)
                scene.truth[y * scene.width + x] = static_cast<float>(scene.exact(x, y, shift * 0.94));
        scene.images = {scene.truth};
        for (uint32_t y = 0; y < scene.height; ++y)
            for (uint32_t x = 0; x < scene.width; ++x)
                scene.images[0][y * scene.width + x] +=
                    static_cast<float>(0.1 * std::sin((x - shift) * 0.35) * std::cos(y * 0.3));
        return scene;
    };
    const PenumbraImages before = image(0), now = image(5.5);  // content moves to the right
    EXPECT_LT(Motion(now, -5.5).step(now, before).rms().value(), 0.002);
    EXPECT_GT(Motion(now, 0).step(now, before).rms().value(), 0.05);
}

TEST(Flicker, OtherSurfacesAndPixelsFromOutsideAreLeftOut) {
    PenumbraImages now, before;
    now.add_rays(1, 1);
    before.add_rays(1, 1);
    Motion motion(now, -20);
    EXPECT_EQ(motion.step(now, before).pixels, (now.width - 20) * now.height);
    motion.change.assign(motion.change.size(), 1.0f);  // it was 10 % further away: another surface
    EXPECT_EQ(motion.step(now, before).pixels, 0u);
    EXPECT_FALSE(motion.step(now, before).rms());
}

// One pixel in fifty flickers: the mean hides it, the percentile does not.
TEST(Flicker, FewPixelsShowInThePercentile) {
    PenumbraImages even, odd;
    even.images = {even.truth};
    odd.images = {odd.truth};
    for (size_t p = 0; p < odd.truth.size(); p += 50) odd.images[0][p] += 0.5f;
    const FlickerSums sums = Motion(even, 0).step(odd, even);
    EXPECT_NEAR(sums.p99().value(), 0.5, 1e-6);
    EXPECT_LT(sums.rms().value(), 0.08);
}

// A shadow that grows by `speed` pixels per frame, and an image that shows it `late` pixels ago.
double measured_lag(double penumbra_px, double speed, double late, int rays = 0) {
    PenumbraImages now(penumbra_px, 0), before(penumbra_px, -speed);
    PenumbraImages shown(penumbra_px, speed > 0 ? -late : late);
    if (rays)
        shown.add_rays(1, rays);
    else
        shown.images = {shown.truth};
    now.images = shown.images;
    return lag_px(now.frame(), before.truth).value();
}

TEST(Lag, ShiftedEdgeIsFoundInBothDirectionsToAFractionOfAPixel) {
    for (const double width : {4.0, 16.0, 48.0})
        for (const double speed : {-2.0, -0.25, 0.25, 2.0})
            for (const double late : {0.0, 0.4, 3.0, 11.0})
                EXPECT_NEAR(measured_lag(width, speed, late), late, 0.06)
                    << width << " px, " << speed << " px per frame";
}

TEST(Lag, AheadIsNegativeAndNoiseDoesNotMatter) {
    EXPECT_NEAR(measured_lag(16, 1, -2), -2, 0.06);
    EXPECT_NEAR(measured_lag(16, 1, 5, 1), 5, 0.4);  // one ray per pixel
}

TEST(Lag, NothingMovesNothingLags) {
    PenumbraImages scene(16);
    scene.images = {scene.truth};
    EXPECT_FALSE(lag_px(scene.frame(), scene.truth));
}

// The edge jumps by 40 pixels at frame 3; the image follows with what a moving average of `weight` leaves.
struct Jump {
    PenumbraImages old{16, -20}, now{16, 20};

    StepResponse response(double weight, uint32_t frames) const {
        StepFinder finder;
        for (uint32_t frame = 0; frame < frames; ++frame)
            finder.add(frame, frame < 3 ? old.truth : now.truth, now.counted);
        const auto step = finder.step().value();
        EXPECT_EQ(step.frame, 3u);
        std::vector<double> remainders;
        for (uint32_t k = 0; 3 + k < frames; ++k) {
            PenumbraImages shown = now;
            shown.images = {now.truth};
            const double left = std::pow(1 - weight, k + 1);
            for (size_t p = 0; p < now.truth.size(); ++p)
                shown.images[0][p] += static_cast<float>(left) * (old.truth[p] - now.truth[p]);
            remainders.push_back(step_remainder(step, shown.frame()));
            EXPECT_NEAR(remainders.back(), left, 1e-6);
        }
        return step_response(remainders);
    }
};

// (1 - a)^(k + 1) <= .1 for a = .5 first at k = 3; all of the remainders sum to (1 - a) / a.
TEST(Lag, StepResponseOfAMovingAverageIsItsOwn) {
    const StepResponse r = Jump().response(0.5, 40);
    EXPECT_EQ(r.k90, 3);
    EXPECT_NEAR(r.residual.value(), 1, 1e-5);
    EXPECT_EQ(Jump().response(1, 10).k90, 0);
    EXPECT_FALSE(Jump().response(0.05, 12).k90);  // has not settled within the frames: not known
    EXPECT_FALSE(step_response({}).residual);
}

// A relapse counts: the naive first time below a tenth would say 0.
TEST(Lag, StepResponseWaitsForTheLastRelapse) {
    const std::vector<double> remainders{0.05, 0.2, 0.15, 0.09, 0.01};
    EXPECT_EQ(step_response(remainders).k90, 3);
}

TEST(Lag, SlowChangesGapsAndPassingShadowsAreNoStep) {
    const PenumbraImages a(16, 0), b(16, 2), far(16, 30);
    StepFinder slow, gap, passing;
    for (uint32_t frame = 0; frame < 2; ++frame) slow.add(frame, frame ? b.truth : a.truth, a.counted);
    EXPECT_FALSE(slow.step());
    gap.add(0, a.truth, a.counted);
    gap.add(2, far.truth, a.counted);
    EXPECT_FALSE(gap.step());
    passing.add(0, a.truth, a.counted);
    passing.add(1, far.truth, a.counted);
    EXPECT_TRUE(passing.step());
    passing.add(2, a.truth, a.counted);  // gone again: a step back, not the one before
    ASSERT_TRUE(passing.step());
    EXPECT_EQ(passing.step()->frame, 2u);
}

}  // namespace
}  // namespace penumbra::test
