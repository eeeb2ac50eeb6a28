// SPDX-License-Identifier: MIT
// The measuring stick against answers known beforehand: a renderer that really takes N samples per pixel must
// read N.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "host/metrics/mask_error.h"
#include "host/truth/concentric_disc.h"
#include "tests/penumbra_images.h"

namespace penumbra {
namespace {

struct Scene : test::PenumbraImages {
    using PenumbraImages::PenumbraImages;
    MetricSums sums() const { return measure(frame()); }
    MaskMetrics metrics() const { return metrics_of(sums()); }
};

double ray(double v, std::mt19937& random) {
    return test::one_ray(v, random);
}
using test::mean_of_rays;

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

// The same errors seen in eight frames are no more evidence than in one.
TEST(Metrics, NeighbouringFramesDoNotNarrowTheInterval) {
    Scene scene;
    scene.add_rays(1, 4);
    MetricSums once = scene.sums(), apart, near;
    for (uint32_t i = 0; i < 8; ++i) {
        apart.add_frame(metric_block_frames * i, once);
        near.add_frame(4 * i, once);
    }
    const auto width = [](const MetricSums& sums) {
        const auto [low, high] = metrics_of(sums).n_eff_ci95.value();
        return high - low;
    };
    EXPECT_NEAR(width(near), width(once), 1e-9);
    EXPECT_LT(width(apart), 0.5 * width(once));  // as though they were independent
    EXPECT_NEAR(metrics_of(near).n_eff.value(), metrics_of(once).n_eff.value(), 1e-9);
    EXPECT_THROW(MetricSums().add_correlated(once), std::invalid_argument);
}

// The truth is noisy too: an edge at a random place of each pixel's sun, counted by side^2 stratified rays.
std::vector<float> counted_truth(const Scene& scene, int side) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> in(0, 1);
    std::vector<float> out;
    for (const float v : scene.truth) {
        const double wanted = static_cast<double>(v);
        if (wanted <= 0 || wanted >= 1) {
            out.push_back(v);
            continue;
        }
        double low = -1, high = 1;  // of the edge's distance from the disc's centre
        for (int i = 0; i < 40; ++i) {
            const double d = 0.5 * (low + high);
            const double share = 0.5 + (std::asin(d) + d * std::sqrt(1 - d * d)) / 3.14159265358979;
            (share < wanted ? low : high) = d;
        }
        const double turn = 6.283185307 * in(random);
        int lit = 0;
        for (int i = 0; i < side; ++i)
            for (int j = 0; j < side; ++j) {
                const glm::dvec2 p = concentric_disc((i + in(random)) / side, (j + in(random)) / side);
                lit += p.x * std::cos(turn) + p.y * std::sin(turn) < low;
            }
        out.push_back(static_cast<float>(lit) / static_cast<float>(side * side));
    }
    return out;
}

// Against a truth of 64 rays an image of 200 samples would read 140; and if v(1 - v) / n were taken out, as
// though the rays were not stratified, thousands or nothing.
TEST(Metrics, TheTruthsOwnNoiseIsTakenOut) {
    Scene scene;
    scene.add_rays(4, 200);
    EXPECT_NEAR(scene.metrics().n_eff.value(), 200, 8);
    for (const int side : {8, 16}) {
        Scene noisy = scene;
        noisy.truth = counted_truth(scene, side);
        const std::vector<float> rays(noisy.truth.size(), static_cast<float>(side * side));
        const double naive = noisy.metrics().n_eff.value();
        ComparedFrame frame = noisy.frame();
        frame.reference_rays = rays;
        const MaskMetrics m = metrics_of(measure(frame));
        std::printf("truth of %d rays: N_eff %.1f, as it stands %.1f\n", side * side, m.n_eff.value(), naive);
        EXPECT_NEAR(m.n_eff.value(), 200, 16);
        EXPECT_NEAR(m.rmse_all.value(), noisy.metrics().rmse_all.value(), 1e-12);
        if (side == 8) {
            EXPECT_LT(naive, 160);
        }
        if (m.n_bias) {
            EXPECT_GT(*m.n_bias, 1000);
        }
    }
}

// Of a truth that is nearly dark, few rays know little: that is no noise of the penumbra's.
TEST(Metrics, NoiseBesideThePenumbraIsNotTakenOutOfIt) {
    constexpr size_t pixels = 100;
    std::vector<float> truth(pixels, 0.003f), image = truth;
    truth[0] = 0.5f;
    image[0] = 0.6f;
    const std::vector<uint8_t> counted(pixels, 1);
    std::vector<float> rays(pixels, 4.0f);
    rays[0] = 1024.0f;
    ComparedFrame frame{pixels, 1, truth, counted, {image}};
    frame.reference_rays = rays;
    MetricSums sums = measure(frame);
    sums.add(measure(frame));
    const MaskMetrics m = metrics_of(sums);
    EXPECT_FALSE(m.n_eff) << "all of the errors could be the truth's";
    ASSERT_TRUE(m.n_eff_penumbra);
    EXPECT_NEAR(*m.n_eff_penumbra, 0.25 / (0.01 - reference_variance(0.5, 1024)), 1e-3);
}

}  // namespace
}  // namespace penumbra
