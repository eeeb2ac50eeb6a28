// SPDX-License-Identifier: MIT
// The blue-noise table: uniform, without low frequencies at every threshold, wrapping without a seam, its two
// channels independent. White noise of the same size fails each of the spectral tests by a factor of ten or
// more.
#include "nodes/tables/blue_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

namespace penumbra {
namespace {

constexpr int size = int(blue_noise_size);
using Picture = std::vector<double>;

const std::vector<uint32_t>& table() {
    static const std::vector<uint32_t> made = blue_noise_table();
    return made;
}

Picture channel(int c) {
    Picture p;
    for (uint32_t texel : table()) p.push_back(((texel >> (16 * c) & 65535) + 0.5) / 65536);
    return p;
}

std::vector<std::complex<double>> spectrum(const Picture& p) {  // separable DFT
    std::vector<std::complex<double>> turn(size), rows(p.size()), out(p.size());
    for (int i = 0; i < size; ++i) turn[i] = std::polar(1.0, -2 * std::numbers::pi * i / size);
    for (int y = 0; y < size; ++y)
        for (int k = 0; k < size; ++k)
            for (int x = 0; x < size; ++x) rows[y * size + k] += p[y * size + x] * turn[k * x % size];
    for (int k = 0; k < size; ++k)
        for (int j = 0; j < size; ++j)
            for (int y = 0; y < size; ++y) out[j * size + k] += rows[y * size + k] * turn[j * y % size];
    return out;
}

// Mean power over frequencies below `radius` cycles per tile, relative to white noise of the same variance.
double low_power(const Picture& p, double radius) {
    double mean = 0, variance = 0;
    for (double v : p) mean += v / double(p.size());
    for (double v : p) variance += (v - mean) * (v - mean);
    const auto s = spectrum(p);
    double power = 0;
    int count = 0;
    for (int j = 0; j < size; ++j)
        for (int k = 0; k < size; ++k) {
            const double f = std::hypot(std::min(j, size - j), std::min(k, size - k));
            if (f == 0 || f >= radius) continue;
            power += std::norm(s[j * size + k]);
            ++count;
        }
    return power / count / variance;
}

double correlation(const Picture& a, const Picture& b, int dx, int dy) {
    double sum = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            sum +=
                (a[y * size + x] - 0.5) * (b[(y + dy + size) % size * size + (x + dx + size) % size] - 0.5);
    return sum / (size * size / 12.0);
}

TEST(BlueNoise, EveryValueOccursOnce) {
    for (int c = 0; c < 2; ++c) {
        std::vector<int> seen(size * size);
        for (uint32_t texel : table()) {
            const uint32_t v = texel >> (16 * c) & 65535;
            ASSERT_EQ(v % 4, 2u);
            ++seen[v / 4];
        }
        for (int n : seen) ASSERT_EQ(n, 1);
    }
}

TEST(BlueNoise, HasNoLowFrequencies) {
    for (int c = 0; c < 2; ++c) EXPECT_LT(low_power(channel(c), 16), 0.02);
}

TEST(BlueNoise, HasNoLowFrequenciesAtAnyThreshold) {
    for (int c = 0; c < 2; ++c)
        for (const double threshold : {0.05, 0.1, 0.25, 0.5, 0.75, 0.9}) {
            Picture binary = channel(c);
            for (double& v : binary) v = v < threshold;
            EXPECT_LT(low_power(binary, 10), 0.1) << "channel " << c << " below " << threshold;
        }
}

TEST(BlueNoise, NeighboursDifferAcrossTheSeamAsInside) {
    for (int c = 0; c < 2; ++c) {
        const Picture p = channel(c);
        double seam = 0, inside = 0;
        for (int i = 0; i < size; ++i) {
            seam +=
                std::abs(p[i * size] - p[i * size + size - 1]) + std::abs(p[i] - p[(size - 1) * size + i]);
            for (int k = 1; k < size; ++k)
                inside += (std::abs(p[i * size + k] - p[i * size + k - 1]) +
                           std::abs(p[k * size + i] - p[(k - 1) * size + i])) /
                          (size - 1);
        }
        EXPECT_NEAR(seam / inside, 1, 0.08);
        EXPECT_GT(inside / (2 * size), 0.36) << "neighbours of white noise differ by 1/3 on average";
    }
}

TEST(BlueNoise, ChannelsAreIndependent) {
    const Picture a = channel(0), b = channel(1);
    for (int dy = -3; dy <= 3; ++dy)
        for (int dx = -3; dx <= 3; ++dx)
            EXPECT_LT(std::abs(correlation(a, b, dx, dy)), 0.04) << dx << ", " << dy;
    EXPECT_LT(correlation(a, a, 1, 0), -0.1) << "the test's own check: a channel is correlated with itself";
}

TEST(BlueNoise, IsTheSameEverywhere) {
    uint64_t hash = 14695981039346656037u;  // FNV-1a
    for (uint32_t texel : table())
        for (int i = 0; i < 4; ++i) hash = (hash ^ (texel >> (8 * i) & 255)) * 1099511628211u;
    EXPECT_EQ(hash, 2253134483545058045u) << "if the generator changed on purpose, take the new hash";
}

}  // namespace
}  // namespace penumbra
