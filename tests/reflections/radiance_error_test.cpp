// SPDX-License-Identifier: MIT
// Errors of radiance: N_eff is how many rays it takes to be as good, the truth's own noise is no error of the
// image.
#include "host/metrics/radiance_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace penumbra {
namespace {

// Pixels of a known signal whose single rays are off by a normal deviate of variance 4 per channel.
struct Experiment {
    static constexpr size_t pixels = 40000;
    static constexpr double variance = 4;
    std::vector<float> truth[3], image[3], receiver, roughness, ray_error, noise;

    Experiment(double rays_of_image, double rays_of_truth, float r) {
        std::mt19937 random(3);
        std::normal_distribution<double> deviate;
        for (size_t i = 0; i < pixels; ++i) {
            for (int c = 0; c < 3; ++c) {
                const double exact = 10 + c;
                truth[c].push_back(
                    static_cast<float>(exact + deviate(random) * std::sqrt(variance / rays_of_truth)));
                image[c].push_back(
                    static_cast<float>(exact + deviate(random) * std::sqrt(variance / rays_of_image)));
            }
            receiver.push_back(1);
            roughness.push_back(r);
            ray_error.push_back(3 * variance);
            noise.push_back(static_cast<float>(3 * variance / rays_of_truth));
        }
    }
    RadianceErrorSums sums() const { return radiance_errors(shown(), known()); }
    RadiancePlanes shown() const { return {{image[0], image[1], image[2]}}; }
    RadianceTruth known() const {
        return {200, {{truth[0], truth[1], truth[2]}}, receiver, roughness, ray_error, noise};
    }
};

TEST(RadianceError, CountsTheRaysThatAnImageIsWorth) {
    for (const double rays : {1.0, 8.0, 100.0}) {
        EXPECT_NEAR(*Experiment(rays, 64, 0.2f).sums().n_eff(), rays, 0.04 * rays)
            << "the truth has 64 rays itself";
    }
}

TEST(RadianceError, ClassesAreOfRoughness) {
    EXPECT_EQ(roughness_class(0), 0u);
    EXPECT_EQ(roughness_class(0.05f), 0u);
    EXPECT_EQ(roughness_class(0.06f), 1u);
    EXPECT_EQ(roughness_class(0.3f), 2u);
    EXPECT_EQ(roughness_class(1), 4u);
    const RadianceErrorSums sums = Experiment(4, 64, 0.4f).sums();
    EXPECT_TRUE(sums.n_eff(3));
    EXPECT_FALSE(sums.n_eff(0)) << "no pixel of that roughness";
    EXPECT_EQ(sums.classes[3].pixels, Experiment::pixels);
}

TEST(RadianceError, ABiasCaps) {
    Experiment biased(1e9, 1e9, 0.2f);
    for (auto& plane : biased.image)
        for (float& v : plane) v *= 1.1f;
    EXPECT_NEAR(*biased.sums().bias(), 0.1, 1e-3);
    EXPECT_NEAR(*biased.sums().n_eff(), 12 / (1.0 + 1.21 + 1.44), 0.05);
}

// A pipeline must not gain by what it leaves undone.
TEST(RadianceError, WhatIsNoNumberIsTheWorstError) {
    Experiment clean(4, 64, 0.2f), broken(4, 64, 0.2f);
    for (size_t i = 0; i < Experiment::pixels; i += 2)
        broken.image[i % 3][i] =
            i % 4 ? std::numeric_limits<float>::quiet_NaN() : -std::numeric_limits<float>::infinity();
    const RadianceErrorSums sums = broken.sums(), was = clean.sums();
    EXPECT_EQ(sums.nonfinite, Experiment::pixels / 2);
    EXPECT_EQ(sums.pixels(), Experiment::pixels);
    EXPECT_NEAR(*sums.n_eff(), 12 / (365 / 2.0), 0.01) << "half of the pixels are off by 10, 11 and 12";
    EXPECT_GT(*sums.relmse(), 0.5);
    EXPECT_NEAR(*sums.bias(), -0.5, 0.01);
    EXPECT_NEAR(*was.bias(), 0, 0.01);
    const auto flicker = [&](const Experiment& now, const Experiment& before) {
        return *radiance_errors(now.shown(), now.known(), before.shown(), before.known().signal).flicker();
    };
    EXPECT_GT(flicker(broken, clean), 0.7);
    EXPECT_GT(flicker(clean, broken), 0.7);
    EXPECT_GT(flicker(broken, broken), 0.7);
    EXPECT_NEAR(flicker(clean, clean), 0, 1e-6);
}

TEST(RadianceError, NorDoesItHelpWhereTheTruthIsBlack) {
    Experiment black(4, 64, 0.2f);
    for (size_t i = 0; i < Experiment::pixels; ++i)
        for (int c = 0; c < 3; ++c) {
            black.truth[c][i] = 0;
            black.image[c][i] = std::numeric_limits<float>::quiet_NaN();
        }
    EXPECT_LE(*black.sums().n_eff(), 1.1) << "no better than one ray";
    for (float& error : black.ray_error) error = 0;
    EXPECT_NEAR(*black.sums().relmse(), 1, 1e-6);
    black.receiver[7] = 0;
    EXPECT_EQ(black.sums().pixels(), Experiment::pixels - 1) << "the sky counts in no error";
    EXPECT_EQ(black.sums().nonfinite, Experiment::pixels);
}

TEST(RadianceError, SkyIsNoReceiver) {
    Experiment half(4, 64, 0.2f);
    for (size_t i = 0; i < Experiment::pixels; i += 2) {
        half.receiver[i] = 0;
        half.image[0][i] = 1e6f;
    }
    EXPECT_EQ(half.sums().pixels(), Experiment::pixels / 2);
    EXPECT_NEAR(*half.sums().n_eff(), 4, 0.2);
    EXPECT_EQ(half.sums().fireflies, 0u);
}

TEST(RadianceError, SumsOfPartsAreTheWhole) {
    const RadianceErrorSums a = Experiment(4, 64, 0.1f).sums(), b = Experiment(16, 64, 0.9f).sums();
    RadianceErrorSums both = a;
    both.add(b);
    EXPECT_EQ(*both.n_eff(1), *a.n_eff(1));
    EXPECT_EQ(*both.n_eff(4), *b.n_eff(4));
    EXPECT_NEAR(*both.n_eff(), 2 / (1 / *a.n_eff() + 1 / *b.n_eff()), 1e-9)
        << "a ratio of sums, no mean of ratios";
}

// Neither what is bright beside a bright truth nor a blur of it is one.
TEST(RadianceError, FirefliesAreBrighterThanAllAroundThem) {
    Experiment e(1e9, 1e9, 0.2f);
    const size_t middle = 100 * 200 + 100;
    const auto set = [&](auto& planes, size_t at, float value) {
        for (auto& plane : planes) plane[at] = value;
    };
    set(e.image, middle, 100);
    EXPECT_EQ(e.sums().fireflies, 1u);
    set(e.truth, middle + 4 + 4 * 200, 60);  // four pixels to the right, four down
    EXPECT_EQ(e.sums().fireflies, 0u) << "there is something as bright nearby";
    set(e.truth, middle + 4 + 4 * 200, 10);
    set(e.truth, middle + 5, 60);
    EXPECT_EQ(e.sums().fireflies, 1u) << "five pixels are too far";
    set(e.image, middle, 20);
    EXPECT_EQ(e.sums().fireflies, 0u) << "not twice as bright";
}

TEST(RadianceError, FlickerIsWhatTheErrorChanges) {
    Experiment now(1e9, 1e9, 0.2f), before(1e9, 1e9, 0.2f);
    EXPECT_FALSE(now.sums().flicker()) << "one frame";
    const auto flicker = [&] {
        return *radiance_errors(now.shown(), now.known(), before.shown(), before.known().signal).flicker();
    };
    EXPECT_NEAR(flicker(), 0, 1e-3);
    for (auto* e : {&now, &before})
        for (auto& plane : e->image)
            for (float& v : plane) v += 3;
    EXPECT_NEAR(flicker(), 0, 1e-3) << "an error that stays";
    for (auto& plane : before.truth)
        for (float& v : plane) v += 2;
    for (auto& plane : before.image)
        for (float& v : plane) v += 2;
    EXPECT_NEAR(flicker(), 0, 1e-3) << "what the truth changes";
    for (auto& plane : now.image)
        for (float& v : plane) v += 0.5f;
    const double luminance = 0.2126 * 10 + 0.7152 * 11 + 0.0722 * 12;
    EXPECT_NEAR(flicker(), std::sqrt(0.75 / (luminance * luminance + 0.01)), 1e-3);
}

TEST(RadianceError, PlanesMustFit) {
    Experiment wrong(4, 64, 0.2f);
    wrong.noise.pop_back();
    EXPECT_THROW(wrong.sums(), std::invalid_argument);
}

}  // namespace
}  // namespace penumbra
