// SPDX-License-Identifier: MIT
// The measuring stick against answers known beforehand: a renderer that really takes N samples per pixel must
// read N.
#include "host/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "host/analytic.h"

namespace penumbra {
namespace {

// A straight penumbra, and images of it made in any way.
struct Scene {
    uint32_t width = 128, height = 96;
    std::vector<float> truth;
    std::vector<uint8_t> counted;
    std::vector<std::vector<float>> images;

    explicit Scene(double penumbra_px = 48) : counted(size_t{width} * height, 1) {
        for (uint32_t y = 0; y < height; ++y)
            for (uint32_t x = 0; x < width; ++x) {
                const double across = (x + 0.5 - width / 2.0) * 0.94 + (y + 0.5 - height / 2.0) * 0.34;
                truth.push_back(
                    static_cast<float>(half_plane_visibility(0.01 * 2 * across / penumbra_px, 0.01)));
            }
    }
    template <class Make>
    void add_images(int count, Make make) {
        for (int i = 0; i < count; ++i) {
            std::mt19937 random(static_cast<uint32_t>(100 + i));
            std::vector<float>& image = images.emplace_back();
            for (const float v : truth)
                image.push_back(static_cast<float>(make(static_cast<double>(v), random)));
        }
    }
    MetricSums sums() const {
        ComparedFrame frame{width, height, truth, counted, {}};
        for (const std::vector<float>& image : images) frame.seeds.emplace_back(image);
        return measure(frame);
    }
    MaskMetrics metrics() const { return metrics_of(sums()); }
};

double ray(double v, std::mt19937& random) {
    return std::uniform_real_distribution<double>()(random) < v ? 1 : 0;
}

double mean_of_rays(double v, std::mt19937& random, int rays) {
    double sum = 0;
    for (int i = 0; i < rays; ++i) sum += ray(v, random);
    return sum / rays;
}

TEST(Metrics, OneRayReadsOneAndFourReadFour) {
    Scene one, four;
    one.add_images(16, [](double v, auto& random) { return ray(v, random); });
    four.add_images(16, [](double v, auto& random) { return mean_of_rays(v, random, 4); });
    EXPECT_NEAR(one.metrics().n_eff.value(), 1, 0.03);
    EXPECT_NEAR(four.metrics().n_eff.value(), 4, 0.12);
}

// (2 - a) / a samples for a weight of a.
TEST(Metrics, MovingAverageReadsItsLength) {
    Scene scene;
    scene.add_images(16, [](double v, auto& random) {
        double mean = v;
        for (int i = 0; i < 160; ++i) mean += 0.05 * (ray(v, random) - mean);
        return mean;
    });
    const MaskMetrics m = scene.metrics();
    EXPECT_NEAR(m.n_eff.value(), 39, 1.5);
    EXPECT_NEAR(m.n_variance.value(), 39, 1.5);
    EXPECT_TRUE(!m.n_bias || *m.n_bias > 1500) << *m.n_bias;  // it has none
    const auto [low, high] = m.n_eff_ci95.value();
    EXPECT_LT(low, 39.5);
    EXPECT_GT(high, 38.5);
    EXPECT_LT(high - low, 3);
}

// A constant offset is all bias, and the parts add up by their reciprocals to the whole.
TEST(Metrics, BiasAndVarianceAreTakenApart) {
    Scene scene;
    const double offset = 0.05;
    scene.add_images(12, [&](double v, auto& random) { return mean_of_rays(v, random, 64) + offset; });
    const MaskMetrics m = scene.metrics();
    double signal = 0;
    for (const float v : scene.truth) signal += static_cast<double>(v) * (1 - static_cast<double>(v));
    EXPECT_NEAR(m.n_bias.value(), signal / (offset * offset * static_cast<double>(scene.truth.size())),
                0.05 * *m.n_bias);
    EXPECT_NEAR(m.n_variance.value(), 64, 3);
    EXPECT_NEAR(1 / m.n_eff.value(), 1 / *m.n_variance + 1 / *m.n_bias, 1e-9);
}

TEST(Metrics, ErrorsBesideThePenumbraAreCharged) {
    Scene scene;
    scene.add_images(1, [](double v, auto&) { return v < 0.002 ? 0.1 : v + 0.01; });
    const MaskMetrics m = scene.metrics();
    EXPECT_LT(m.n_eff.value(), 0.5 * m.n_eff_penumbra.value());
    EXPECT_NEAR(m.rmse_penumbra.value(), 0.01, 1e-6);
    EXPECT_NEAR(m.rmse_lit.value(), 0.01, 1e-6);
    EXPECT_NEAR(m.rmse_umbra.value(), 0.1, 1e-3);
    EXPECT_EQ(m.receivers, m.penumbra + m.lit + m.umbra);
    EXPECT_FALSE(m.n_variance);  // one seed cannot tell
}

TEST(Metrics, LeaksAndAcneAreCountedWhereTheyAre) {
    Scene scene;
    scene.images.push_back(scene.truth);
    uint64_t umbra = 0, lit = 0;
    for (size_t p = 0; p < scene.truth.size(); ++p) {
        if (scene.truth[p] == 0 && umbra++ < 7) scene.images[0][p] = 0.2f;
        if (scene.truth[p] == 1 && lit++ < 5) scene.images[0][p] = 0.5f;
    }
    const MaskMetrics m = scene.metrics();
    EXPECT_NEAR(m.leak.value() * static_cast<double>(m.umbra), 7, 1e-9);
    EXPECT_NEAR(m.acne.value() * static_cast<double>(m.lit), 5, 1e-9);
    EXPECT_DOUBLE_EQ(m.max_abs.value(), 0.5);
}

TEST(Metrics, PixelsThatDoNotCountDoNot) {
    Scene scene, masked;
    scene.add_images(1, [](double v, auto&) { return v; });
    scene.images[0][5] = 0.7f;
    EXPECT_FALSE(scene.metrics().psnr_db.value() > 100);
    scene.counted[5] = 0;
    EXPECT_EQ(scene.metrics().rmse_all.value(), 0);
    EXPECT_FALSE(scene.metrics().psnr_db);
    EXPECT_EQ(scene.metrics().receivers, scene.truth.size() - 1);
}

// What is not a number must cost, wherever it stands.
TEST(Metrics, NonFiniteTexelsAreTheWorstError) {
    Scene scene;
    scene.images.push_back(scene.truth);
    scene.images[0][0] = std::numeric_limits<float>::quiet_NaN();
    scene.images[0].back() = std::numeric_limits<float>::infinity();
    const MaskMetrics m = scene.metrics();
    EXPECT_EQ(m.nonfinite, 2u);
    EXPECT_DOUBLE_EQ(m.max_abs.value(), 1);
    EXPECT_NEAR(m.rmse_all.value(), std::sqrt(2.0 / static_cast<double>(scene.truth.size())), 1e-9);
    EXPECT_GT(m.leak.value() + m.acne.value(), 0);
}

// Two frames' sums are the sums of two frames: a ratio of sums, not a mean of ratios.
TEST(Metrics, FramesArePooled) {
    Scene good(64), bad(16);
    good.add_images(2, [](double v, auto& random) { return mean_of_rays(v, random, 64); });
    bad.add_images(2, [](double v, auto& random) { return ray(v, random); });
    MetricSums both = good.sums();
    both.add(bad.sums());
    const double expected =
        (good.sums().signal + bad.sums().signal) /
        (good.sums().signal / good.metrics().n_eff.value() + bad.sums().signal / bad.metrics().n_eff.value());
    EXPECT_NEAR(metrics_of(both).n_eff.value(), expected, 1e-9);
}

}  // namespace
}  // namespace penumbra
