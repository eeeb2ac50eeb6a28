// SPDX-License-Identifier: MIT
// sun_sample.glsl on the device: uniform over the cap for suns of every size and direction, finite at every
// corner of the square and at every pole, continuous around them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/bvh_scenes.h"
#include "tests/gpu_test.h"
#include "tests/vulkan_compute.h"

namespace penumbra {
namespace {

using namespace test;

struct In {
    float to_sun[3], radius, u[2], padding[2];
};
struct Out {
    float exact[4], polar[4], published[4];
};
struct Double3 {
    double x, y, z;
    explicit Double3(const float* v) : x(v[0]), y(v[1]), z(v[2]) {}
    double length() const { return std::sqrt(x * x + y * y + z * z); }
};

double dot(Double3 a, Double3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Exact for small angles, where a cosine would lose all digits.
double angle(const float* a, const float* b) {
    const Double3 p(a), q(b);
    const double x = p.y * q.z - p.z * q.y, y = p.z * q.x - p.x * q.z, z = p.x * q.y - p.y * q.x;
    return std::atan2(std::sqrt(x * x + y * y + z * z), dot(p, q));
}

std::vector<Out> evaluate(const std::vector<In>& in) {
    Compute compute(gpu());
    const VkDescriptorType bindings[] = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                         VK_DESCRIPTOR_TYPE_STORAGE_BUFFER};
    compute.load(SUN_SAMPLE_SPV, bindings);
    const std::vector<Out> none(in.size());
    const std::span<const std::byte> contents[] = {std::as_bytes(std::span(in)),
                                                   std::as_bytes(std::span(none))};
    compute.bind(contents);
    compute.run(uint32_t((in.size() + 63) / 64), uint32_t(in.size()));
    const auto* out = static_cast<const Out*>(compute.mapped(1));
    return {out, out + in.size()};
}

std::vector<Vec> suns() {
    std::vector<Vec> out{normalised({0.3f, 0.8f, 0.5f}), normalised({-0.6f, 0.1f, -0.7f})};
    for (int axis = 0; axis < 3; ++axis)
        for (const float sign : {-1.0f, 1.0f})
            for (const float off : {0.0f, -0.0f, 1e-7f, -1e-7f, 1e-30f}) {
                float v[3] = {off, off, off};
                v[axis] = sign;
                out.push_back({v[0], v[1], v[2]});
            }
    return out;
}

class SunSample : public GpuTest {};

TEST_F(SunSample, IsUniformOverTheCap) {
    constexpr int n = 64;
    Random random(30);
    for (const double radius : {1e-4, 0.00465, 0.0349, 0.1745, 0.7854}) {
        for (const Vec& sun : suns()) {
            std::vector<In> in;
            for (int y = 0; y < n; ++y)
                for (int x = 0; x < n; ++x)
                    in.push_back({{sun.x, sun.y, sun.z},
                                  float(radius),
                                  {(float(x) + random.unit()) / n, (float(y) + random.unit()) / n},
                                  {}});
            const std::vector<Out> out = evaluate(in);
            for (const auto form : {&Out::exact, &Out::polar}) {
                SCOPED_TRACE(form == &Out::exact ? "concentric" : "polar");
                // For a uniform cap (1 - cos t) / (1 - cos a) is uniform in [0, 1] and the mean direction is
                // the axis.
                std::vector<double> height;
                double sum[3] = {};
                for (size_t i = 0; i < out.size(); ++i) {
                    const float* direction = out[i].*form;
                    ASSERT_NEAR(Double3(direction).length(), 1, 5e-7);
                    const double t = angle(direction, in[i].to_sun);
                    ASSERT_LT(t, radius * (1 + 1e-5) + 2e-7);
                    const double s = std::sin(t / 2) / std::sin(radius / 2);
                    height.push_back(s * s);
                    for (int a = 0; a < 3; ++a)
                        sum[a] += (direction[a] - in[i].to_sun[a]) / double(out.size());
                }
                std::sort(height.begin(), height.end());
                double furthest = 0;
                for (size_t i = 0; i < height.size(); ++i)
                    furthest =
                        std::max(furthest, std::abs(height[i] - (double(i) + 0.5) / double(height.size())));
                // 64 x 64 stratified points resolve the cap's area to better than 1 %, or one of 64 rings
                // where there are rings; the rest is rounding at small radii.
                EXPECT_LT(furthest, (form == &Out::exact ? 0.01 : 1.0 / n) + 4e-7 / radius)
                    << "radius " << radius;
                // What is left across the axis after averaging; along it the mean is (1 - cos a) / 2 below 1.
                const double along = sum[0] * sun.x + sum[1] * sun.y + sum[2] * sun.z;
                EXPECT_NEAR(along, -std::pow(std::sin(radius / 2), 2), 2e-3 * radius * radius + 1e-7);
                const double across[3] = {sum[0] - along * sun.x, sum[1] - along * sun.y,
                                          sum[2] - along * sun.z};
                EXPECT_LT(std::hypot(across[0], across[1], across[2]), 1e-3 * radius + 1e-7);
            }
        }
    }
}

TEST_F(SunSample, PublishedFormIsTheTangentDisc) {
    std::vector<In> in;
    for (const Vec& sun : suns())
        for (int i = 0; i < 256; ++i)
            in.push_back({{sun.x, sun.y, sun.z}, 0.1745f, {float(i % 16) / 15, float(i / 16) / 15}, {}});
    const std::vector<Out> out = evaluate(in);
    double widest = 0;
    for (size_t i = 0; i < in.size(); ++i) {
        // The square's concentric ring through u has radius max(|2u - 1|).
        const double r = std::max(std::abs(2.0 * in[i].u[0] - 1), std::abs(2.0 * in[i].u[1] - 1));
        const double t = angle(out[i].published, in[i].to_sun);
        ASSERT_NEAR(std::tan(t), r * std::tan(0.1745), 2e-6);
        widest = std::max(widest, t);
    }
    EXPECT_NEAR(widest, 0.1745, 1e-5);
}

TEST_F(SunSample, MiddleAndZeroRadiusAreTheSunItself) {
    std::vector<In> in;
    for (const Vec& sun : suns()) {
        in.push_back({{sun.x, sun.y, sun.z}, 0.2f, {0.5f, 0.5f}, {}});
        for (const float u : {0.0f, 0.25f, 1.0f}) in.push_back({{sun.x, sun.y, sun.z}, 0, {u, 1 - u}, {}});
    }
    const std::vector<Out> out = evaluate(in);
    for (size_t i = 0; i < in.size(); ++i)
        for (int a = 0; a < 3; ++a) {
            EXPECT_NEAR(out[i].exact[a], in[i].to_sun[a], 1e-7);
            EXPECT_NEAR(out[i].published[a], in[i].to_sun[a], 2e-7);
        }
}

// Which is why no direction is preferred: what the noise is along one, it is along all.
TEST_F(SunSample, AShiftOfTheFirstNumberTurnsTheDisc) {
    constexpr float radius = 0.1f;
    constexpr double turn = 2 * std::numbers::pi / 8;
    Random random(31);
    std::vector<In> in;
    for (int i = 0; i < 256; ++i) {
        const float u = 0.875f * random.unit(), v = random.unit();
        in.push_back({{0, 0, 1}, radius, {u, v}, {}});
        in.push_back({{0, 0, 1}, radius, {u + 0.125f, v}, {}});
    }
    const std::vector<Out> out = evaluate(in);
    double of_concentric = 0;
    const auto apart = [&](const float* from, const float* to) {
        return std::hypot(std::cos(turn) * from[0] - std::sin(turn) * from[1] - to[0],
                          std::sin(turn) * from[0] + std::cos(turn) * from[1] - to[1]);
    };
    for (size_t i = 0; i < out.size(); i += 2) {
        ASSERT_LT(apart(out[i].polar, out[i + 1].polar), 1e-6 * radius + 1e-7);
        of_concentric = std::max(of_concentric, apart(out[i].exact, out[i + 1].exact));
    }
    EXPECT_GT(of_concentric, 0.1 * radius);
}

}  // namespace
}  // namespace penumbra
