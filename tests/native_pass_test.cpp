// SPDX-License-Identifier: MIT
// The unit of cost does what it says: the same as a plain loop, pixel by pixel.
#include "app/bench/native_pass.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/packing.hpp>
#include <glm/packing.hpp>

namespace penumbra {
namespace {

glm::vec2 filtered(const NativeImages& images, int x, int y) {
    const size_t here = images.at(uint32_t(x), uint32_t(y));
    const glm::vec3 n = 2.0F * glm::vec3(glm::unpackUnorm3x10_1x2(images.normal[here])) - 1.0F;
    float mean = 0, variance = 0, weights = 0;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            if (x + dx < 0 || y + dy < 0 || x + dx >= int(images.width) || y + dy >= int(images.height))
                continue;
            const size_t there = images.at(uint32_t(x + dx), uint32_t(y + dy));
            const glm::vec2 s = glm::unpackHalf2x16(images.signal[there]);
            const glm::vec3 m = 2.0F * glm::vec3(glm::unpackUnorm3x10_1x2(images.normal[there])) - 1.0F;
            const float cosine = std::max(glm::dot(n, m), 0.0F);
            const float off =
                (images.depth[there] - images.depth[here]) / (native_tolerance * images.depth[here]);
            const float w = native_kernel[dx & 1] * native_kernel[dy & 1] * cosine * cosine * cosine *
                            cosine / (1 + off * off);
            mean += w * s.x;
            variance += w * w * s.y;
            weights += w;
        }
    return {mean / weights, variance / (weights * weights)};
}

using Pass = void (*)(const NativeImages&, std::vector<uint32_t>&);

void expect_filtered(Pass pass) {
    const NativeImages images = native_images(64, 40);
    std::vector<uint32_t> out(images.signal.size());
    pass(images, out);
    double changed = 0;
    for (int y = 0; y < int(images.height); ++y)
        for (int x = 0; x < int(images.width); ++x) {
            const size_t at = images.at(uint32_t(x), uint32_t(y));
            const glm::vec2 is = glm::unpackHalf2x16(out[at]), should = filtered(images, x, y);
            ASSERT_NEAR(is.x, should.x, 1e-3) << x << ", " << y;
            ASSERT_NEAR(is.y, should.y, 1e-3) << x << ", " << y;
            changed += std::abs(is.x - glm::unpackHalf2x16(images.signal[at]).x);
        }
    EXPECT_GT(changed / (images.width * images.height), 0.1);
}

TEST(NativePass, ByHandFiltersAsTheFormulaSays) {
    if (!has_avx2()) GTEST_SKIP() << "a processor without AVX2, FMA or F16C";
    expect_filtered(native_pass_avx2);
}

TEST(NativePass, APlainLoopDoesTheSame) {
    expect_filtered(native_pass_plain);
}

}  // namespace
}  // namespace penumbra
