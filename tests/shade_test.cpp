// SPDX-License-Identifier: MIT
// The nodes resolve and shade on a device: sky is lit whatever the words say, the sun gives nothing to a
// surface that faces away from it, and all else is the Lambert formula in double precision.
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <random>

#include "shaders/common/blocks.h"
#include "tests/gpu_test.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr const char* pipeline_text = R"({
  "penumbra": 1, "name": "shade", "inputs": { "depth": {}, "normal": {}, "albedo": {}, "sun": {}, "ray_hits": {} },
  "outputs": ["lit", "visibility"],
  "nodes": {
    "guides": { "type": "guides" },
    "classify": { "type": "classify" },
    "resolve": { "type": "resolve", "in": { "hits": "ray_hits" } },
    "shade": { "type": "shade", "params": { "sun_color": [3, 2, 1], "ambient": [0.25, 0.5, 0.125] } }
  }
})";
const glm::dvec3 sun_color(3, 2, 1), ambient(0.25, 0.5, 0.125);

class ShadeTest : public GpuTest, public ::testing::WithParamInterface<bool> {};

TEST_P(ShadeTest, ResolvesWordsAndShadesByLambert) {
    for (const Extent extent : {Extent{67, 45}, Extent{17, 1}}) {
        SCOPED_TRACE(testing::Message() << extent.width << "x" << extent.height);
        ViewRunOptions options;
        options.cpu = GetParam();
        options.formats = {{"depth", Format::r32f}, {"normal", Format::rgba16f}, {"albedo", Format::rgba8}};
        options.captures = {"view_depth", "guide_normal"};
        ViewRun run(shadow_pipeline(pipeline_text), extent, options);

        const size_t n = static_cast<size_t>(extent.width) * extent.height;
        const uint32_t across = (extent.width + 7) / 8, down = (extent.height + 3) / 4;
        std::mt19937 random(extent.width);
        std::vector<float> depth(n);
        std::vector<std::array<uint16_t, 4>> normal(n);
        std::vector<std::array<uint8_t, 4>> albedo(n);
        std::vector<uint32_t> hits(static_cast<size_t>(across) * down);
        for (float& d : depth) d = random() % 4 ? 0.01f : 0.0f;
        for (auto& texel : normal) {
            std::normal_distribution<double> any;
            const glm::dvec3 v = glm::normalize(glm::dvec3(any(random), any(random), any(random)));
            texel = to_half4({v.x, v.y, v.z, 0});
        }
        for (auto& texel : albedo)
            texel = {static_cast<uint8_t>(random()), static_cast<uint8_t>(random()),
                     static_cast<uint8_t>(random()), 255};
        for (uint32_t& word : hits) word = static_cast<uint32_t>(random());
        const glm::dvec3 to_sun(0.48, 0.64, 0.6);
        run.set("depth", depth);
        run.set("normal", normal);
        run.set("albedo", albedo);
        run.set("ray_hits", hits);
        run.set("sun", std::vector<blocks::Sun>{{{{0.48f, 0.64f, 0.6f}}, 0.01f}});
        const Camera camera = camera_at({0, 0, 0}, 0, extent);
        run.frame(frame_between(camera, camera, extent, 0, true));

        const auto visibility = captured_planes(run.view(), "visibility"),
                   lit = captured_planes(run.view(), "lit");
        const auto guide = captured_planes(run.view(), "guide_normal");
        size_t sky = 0, occluded = 0, away = 0;
        for (size_t i = 0; i < n; ++i) {
            const size_t x = i % extent.width, y = i / extent.width;
            const bool receiver = depth[i] > 0, hit = hits[y / 4 * across + x / 8] >> (y % 4 * 8 + x % 8) & 1;
            const double v = receiver && hit ? 0 : 1;
            ASSERT_EQ(visibility[0][i], static_cast<float>(v))
                << "pixel " << x << ", " << y << (receiver ? "" : ", sky");
            glm::dvec3 expected;
            if (receiver) {
                const glm::dvec3 direction(2.0 * static_cast<double>(guide[0][i]) - 1,
                                           2.0 * static_cast<double>(guide[1][i]) - 1,
                                           2.0 * static_cast<double>(guide[2][i]) - 1);
                const double facing = glm::dot(glm::normalize(direction), to_sun);
                const glm::dvec3 a = glm::dvec3(albedo[i][0], albedo[i][1], albedo[i][2]) / 255.0;
                expected = a * (sun_color * std::max(facing, 0.0) * v + ambient);
                occluded += hit;
                away += facing <= 0;
            } else {
                const glm::dvec2 ndc =
                    2.0 * (glm::dvec2(x, y) + 0.5) / glm::dvec2(extent.width, extent.height) - 1.0;
                const glm::dvec3 ray(ndc.x / camera.clip_from_view[0], ndc.y / camera.clip_from_view[5], -1);
                const double up = std::clamp(glm::normalize(ray).y, 0.0, 1.0);
                expected =
                    ambient *
                    glm::mix(glm::dvec3(0.80, 0.87, 0.95), glm::dvec3(0.22, 0.42, 0.75), std::sqrt(up)) * 4.0;
                ++sky;
            }
            for (size_t c = 0; c < 3; ++c) {
                const double wanted = expected[static_cast<int>(c)];
                ASSERT_NEAR(lit[c][i], wanted, half_ulp(wanted) + 2e-5)
                    << "pixel " << x << ", " << y << (receiver ? "" : ", sky");
            }
        }
        EXPECT_GT(sky, 0u);
        EXPECT_GT(occluded, 0u);
        EXPECT_GT(away, 0u);
    }
}

INSTANTIATE_TEST_SUITE_P(Shapes, ShadeTest, ::testing::Bool(),
                         [](const auto& test) { return std::string(test.param ? "Cpu" : "Gpu"); });

}  // namespace
}  // namespace penumbra::test
