// SPDX-License-Identifier: MIT
// Metrics of one frame other than its plain errors: structure, the lit picture, bias, contact, decisions.
// Each on inputs whose answer is known beforehand.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "host/metrics/metrics.h"
#include "tests/penumbra_images.h"

namespace penumbra::test {
namespace {

using glm::vec3;

double ssim_of(const PenumbraImages& scene) {
    return ssim_near_penumbra(scene.frame()).mean().value();
}

TEST(Ssim, OneForTheTruthAndLessForNoise) {
    PenumbraImages same, noise_1, noise_16;
    same.images.push_back(same.truth);
    noise_1.add_rays(1, 1);
    noise_16.add_rays(1, 16);
    EXPECT_DOUBLE_EQ(ssim_of(same), 1);
    EXPECT_LT(ssim_of(noise_1), ssim_of(noise_16));
    EXPECT_LT(ssim_of(noise_16), 0.9);
}

// Of two constants a and b the structure term is 1 and the rest is (2ab + C1) / (a^2 + b^2 + C1).
TEST(Ssim, OfConstantsIsTheLuminanceTerm) {
    PenumbraImages scene;
    scene.truth.assign(scene.truth.size(), 0.4f);
    scene.images.push_back(std::vector<float>(scene.truth.size(), 0.7f));
    EXPECT_NEAR(ssim_of(scene), (2 * 0.4 * 0.7 + 1e-4) / (0.16 + 0.49 + 1e-4), 1e-6);
}

// A mask is mostly constant; averaged over all of it, the worst noise in a narrow penumbra would still score
// near 1.
TEST(Ssim, LooksAtThePenumbraAlone) {
    PenumbraImages scene(4);
    scene.add_rays(1, 1);
    const SsimSum sum = ssim_near_penumbra(scene.frame());
    EXPECT_LT(sum.pixels, scene.truth.size() / 3);
    EXPECT_LT(sum.mean().value(), 0.8);
    scene.truth.assign(scene.truth.size(), 1);
    EXPECT_FALSE(ssim_near_penumbra(scene.frame()).mean());
}

TEST(Ssim, NaNIsNotForgiven) {
    PenumbraImages scene;
    scene.images.push_back(scene.truth);
    scene.images[0][48 * scene.width + 64] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_LT(ssim_of(scene), 1 - 1e-4);
}

TEST(BiasMap, FindsAnOffsetUnderNoiseAndNoiseHasNone) {
    PenumbraImages clean, biased;
    clean.add_rays(16, 64);
    biased.add_rays(16, 64);
    for (auto& image : biased.images)
        for (uint32_t y = 40; y < 52; ++y)
            for (uint32_t x = 50; x < 62; ++x) image[y * biased.width + x] += 0.03f;
    EXPECT_LT(largest_bias_9x9(clean.frame()).value(), 0.008);  // .5 / sqrt(16 * 64 * 81) = .0017
    EXPECT_NEAR(largest_bias_9x9(biased.frame()).value(), 0.03, 0.006);
    EXPECT_GT(metrics_of(measure(clean.frame())).max_abs.value(), 0.15);  // the naive form sees noise alone
    clean.counted.assign(clean.counted.size(), 0);
    EXPECT_FALSE(largest_bias_9x9(clean.frame()));
}

struct Uniform {
    uint32_t width = 24, height = 20;
    std::vector<vec3> of(vec3 color) const { return std::vector<vec3>(size_t{width} * height, color); }
    double mean(vec3 a, vec3 b) const { return pool_flip(flip_map(width, height, of(a), of(b)))->mean; }
};

// Green against blue defines the scale's end. White against black: L* differs by 100, chroma not at all;
// 100^.7 = 25.1 against the scale's 41.3 lies beyond its knee of .4 * 41.3.
TEST(Flip, UniformColoursHaveKnownDifferences) {
    const Uniform u;
    EXPECT_NEAR(u.mean({0, 1, 0}, {0, 0, 1}), 1, 1e-6);
    EXPECT_NEAR(u.mean({1, 1, 1}, {0, 0, 0}), 0.9674, 1e-4);
    EXPECT_EQ(u.mean({0.3f, 0.5f, 0.2f}, {0.3f, 0.5f, 0.2f}), 0);
    // L* 76.07 and 77.07 (.5 and .51624 of white's luminance): 1^.7 = 1 of a knee at 16.5, times .95.
    EXPECT_NEAR(u.mean(vec3(0.5f), vec3(0.516240f)), 0.95 / (0.4 * 41.27), 2e-3);
}

std::vector<vec3> textured(const Uniform& u, uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> in(0, 1);
    std::vector<vec3> image = u.of({});
    for (vec3& pixel : image) pixel = {in(random), in(random), in(random)};
    return image;
}

TEST(Flip, IsSymmetricAndZeroOnlyForTheSame) {
    const Uniform u;
    const auto a = textured(u, 1), b = textured(u, 2);
    const auto ab = flip_map(u.width, u.height, a, b), ba = flip_map(u.width, u.height, b, a);
    for (size_t p = 0; p < ab.size(); ++p) {
        EXPECT_FLOAT_EQ(ab[p], ba[p]);
        EXPECT_GT(ab[p], 0);
        EXPECT_LE(ab[p], 1);
    }
    EXPECT_EQ(pool_flip(flip_map(u.width, u.height, a, a))->mean, 0);
}

// From far away fine noise is not seen; a per-pixel difference would not care.
TEST(Flip, FineNoiseIsSeenLessThanTheSameErrorInOnePiece) {
    const Uniform u{64, 64};
    auto noise = u.of(vec3(0.5f)), blob = u.of(vec3(0.5f));
    for (uint32_t y = 0; y < 64; ++y)
        for (uint32_t x = 0; x < 64; ++x) {
            noise[y * 64 + x] = vec3((x + y) % 2 ? 0.55f : 0.45f);
            blob[y * 64 + x] = vec3(x < 32 ? 0.55f : 0.45f);
        }
    const auto grey = u.of(vec3(0.5f));
    const double seen_noise = pool_flip(flip_map(64, 64, grey, noise))->mean,
                 seen_blob = pool_flip(flip_map(64, 64, grey, blob))->mean;
    EXPECT_LT(seen_noise, 0.8 * seen_blob);
    const double closer = pool_flip(flip_map(64, 64, grey, noise, 10))->mean;
    EXPECT_GT(closer, seen_noise);  // ten pixels per degree: each is seen
}

// An edge that was not there raises the difference beyond that of its colours.
TEST(Flip, EdgesCount) {
    const Uniform u{64, 32};
    auto edge = u.of(vec3(0.2f));
    for (size_t p = 0; p < edge.size(); ++p)
        if (p % 64 >= 32) edge[p] = vec3(0.3f);
    const auto map = flip_map(64, 32, u.of(vec3(0.2f)), edge);
    EXPECT_GT(map[16 * 64 + 33], 1.15f * map[16 * 64 + 60]);
    EXPECT_EQ(map[16 * 64 + 2], 0);
}

TEST(Flip, PoolsByWeight) {
    std::vector<float> values(100, 0);
    values[3] = 1;
    for (size_t i = 10; i < 30; ++i) values[i] = 0.1f;
    const FlipPool pool = pool_flip(values).value();
    EXPECT_NEAR(pool.mean, 0.03, 1e-6);
    EXPECT_FLOAT_EQ(static_cast<float>(pool.weighted_median), 0.1f);  // half of the sum of 3 lies below
    EXPECT_FLOAT_EQ(static_cast<float>(pool.p95), 0.1f);
    EXPECT_FALSE(pool_flip({}));
}

TEST(Shaded, RelativeErrorOfAConstantOffsetIsKnown) {
    PenumbraImages scene;
    scene.truth.assign(scene.truth.size(), 0.5f);
    scene.images.push_back(std::vector<float>(scene.truth.size(), 0.75f));
    const std::vector<vec3> albedo(scene.truth.size(), vec3(0.5f)), normal(scene.truth.size(), {0, 0, 1});
    const Surfaces surfaces{albedo, normal, {0, 0.6, 0.8}};
    const auto image = shade_surfaces(surfaces, scene.frame(), scene.images[0]),
               truth = shade_surfaces(surfaces, scene.frame(), scene.truth);
    EXPECT_NEAR(truth[7].x, 0.5 * (3.0 * 0.8 * 0.5 + 0.16), 1e-6);
    double expected = 0;
    for (const auto& [sun, sky] : {std::pair{3.0, 0.16}, {2.8, 0.19}, {2.5, 0.24}}) {
        const double v = 0.5 * (sun * 0.4 + sky), d = 0.5 * sun * 0.2;
        expected += d * d / (v * v + 0.01) / 3;
    }
    EXPECT_NEAR(relative_error(scene.frame(), image, truth).mean().value(), expected, 1e-5);
    EXPECT_EQ(relative_error(scene.frame(), truth, truth).mean().value(), 0);
    for (const vec3& pixel : display_linear(image)) EXPECT_LE(pixel.x, 1);
}

// A wall along x = 20 whose shadow falls to the right; the image's begins three pixels later.
TEST(Contact, GapIsMeasuredInPixels) {
    PenumbraImages scene;
    std::vector<float> late(scene.truth.size());
    for (size_t p = 0; p < scene.truth.size(); ++p) {
        const size_t x = p % scene.width;
        scene.truth[p] = x >= 20 && x < 60 ? 0.0f : 1.0f;
        late[p] = x >= 23 && x < 60 ? 0.0f : 1.0f;
    }
    scene.images = {scene.truth};
    const ContactLine line{{20, 10}, {20, 80}, {1, 0}};
    EXPECT_NEAR(peter_panning_px(scene.frame(), line).value(), 0, 1e-9);
    scene.images = {late};
    EXPECT_NEAR(peter_panning_px(scene.frame(), line).value(), 3, 1e-9);
    scene.images = {std::vector<float>(scene.truth.size(), 1.0f)};
    EXPECT_GT(peter_panning_px(scene.frame(), line).value(), 60);  // no shadow at all
    const ContactLine nowhere{{100, 10}, {100, 80}, {1, 0}};
    EXPECT_FALSE(peter_panning_px(scene.frame(), nowhere));
}

struct Decided {
    PenumbraImages scene{24};
    std::vector<uint32_t> undecided, shadowed;

    Decided() {
        scene.images.push_back(scene.truth);
        undecided.assign(scene.width / 8 * (scene.height / 4), 0);
        shadowed = undecided;
        for (size_t p = 0; p < scene.truth.size(); ++p) {
            if (in_penumbra(static_cast<double>(scene.truth[p]))) set(undecided, p);
            if (static_cast<double>(scene.truth[p]) < penumbra_eps) set(shadowed, p);
        }
    }
    void set(std::vector<uint32_t>& words, size_t p) const {
        const size_t x = p % scene.width, y = p / scene.width;
        words[y / 4 * (scene.width / 8) + x / 8] ^= 1u << (y % 4 * 8 + x % 8);
    }
    size_t find(double low, double high) const {
        size_t p = 0;
        while (!(static_cast<double>(scene.truth[p]) >= low && static_cast<double>(scene.truth[p]) <= high))
            ++p;
        return p;
    }
    DecisionSums sums() const { return judge_decisions(scene.frame(), {undecided, shadowed}); }
};

TEST(Decisions, PerfectOnesAreNeverWrongAndRaysMeetThePenumbraAlone) {
    const DecisionMetrics m = metrics_of(Decided().sums());
    EXPECT_EQ(m.recall, 1);
    EXPECT_EQ(m.eta_ray, 1);
    EXPECT_EQ(m.traced_per_penumbra, 1);
    EXPECT_EQ(m.beyond_eps, 0);
    EXPECT_LT(m.rms.value(), penumbra_eps);
}

TEST(Decisions, WrongOnesAreFoundByKindAndSize) {
    Decided d;
    const size_t half = d.find(0.45, 0.55), dark = d.find(0, 0.001), faint = d.find(0.93, 0.945);
    d.set(d.undecided, half);   // decided lit though half dark
    d.set(d.undecided, faint);  // lit though .06 of the sun is hidden
    d.set(d.shadowed, dark);    // lit though dark
    const size_t lit = d.find(1, 1);
    d.set(d.shadowed, lit);
    const DecisionSums s = d.sums();
    EXPECT_EQ(s.beyond_eps, 4u);
    EXPECT_EQ(s.beyond_05, 4u);
    EXPECT_EQ(s.beyond_25, 3u);
    EXPECT_EQ(s.false_lit, 3u);
    EXPECT_EQ(s.false_shadow, 1u);
    const DecisionMetrics m = metrics_of(s);
    EXPECT_NEAR(m.recall.value(), 1 - 2.0 / static_cast<double>(s.penumbra), 1e-12);
    EXPECT_EQ(m.eta_ray, 1);
    d.set(d.undecided, lit);  // a ray that was not needed
    EXPECT_LT(metrics_of(d.sums()).eta_ray.value(), 1);
    EXPECT_EQ(metrics_of(d.sums()).traced_per_penumbra, double(s.penumbra - 1) / double(s.penumbra));
    d.undecided.pop_back();
    EXPECT_THROW(d.sums(), std::invalid_argument);
}

}  // namespace
}  // namespace penumbra::test
