// SPDX-License-Identifier: MIT
// Hard cases 7, 8, 10, 11: whether what a pixel shows is what the previous frame showed there, from a grazing
// view, through a zoom, behind a step and on a slope.
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <random>

#include "tests/hard_cases/hard_cases.h"
#include "tests/shipped.h"

namespace penumbra::test {
namespace {

constexpr Extent wide{160, 96};

// One bit per pixel and frame with the mean 1/2: every block has work.
std::vector<uint32_t> noise(Extent extent, uint32_t frame) {
    std::mt19937 random(frame + 1);
    return hit_words(extent, [&](uint32_t, uint32_t) { return (random() & 1) != 0; });
}

constexpr uint32_t looked_at = 12;  // frame; until then the samples' own noise shortens histories

// Share of the plane's pixels without a history, though the previous frame showed all of them. `believed` is
// the previous camera as the host has it, for its motion, too.
double ours_forgotten(const ViewedPlane& plane, const std::function<Camera(double)>& camera,
                      const std::function<Camera(double)>& believed) {
    DenoiseRun run(denoiser(), wide, {"state"});
    for (uint32_t f = 0; f <= looked_at; ++f)
        run.frame(see_plane(plane, believed(f), camera(f), wide), noise(wide, f),
                  frame_between(believed(f), camera(f), wide, f, f == 0));
    const std::vector<float> count = run.kept_frames();
    const PlaneImages images = see_plane(plane, camera(looked_at - 1), camera(looked_at), wide);
    size_t seen = 0, forgotten = 0;
    for (size_t i = 0; i < count.size(); ++i) {
        const glm::dvec2 uv((double(i % wide.width) + 0.5) / wide.width + images.motion[i][0],
                            (double(i / wide.width) + 0.5) / wide.height + images.motion[i][1]);
        if (!(images.depth[i] > 0) || uv.x < 0.02 || uv.y < 0.02 || uv.x > 0.98 || uv.y > 0.98) continue;
        ++seen;
        forgotten += count[i] < 1.5f;
    }
    return share(forgotten, seen);
}

// The test of many renderers: the previous depth at the nearest texel agrees with the expected one to 1 %.
double naive_forgotten(const ViewedPlane& plane, const std::function<Camera(double)>& camera) {
    const Camera c = camera(looked_at), b = camera(looked_at - 1);
    const PlaneImages before = see_plane(plane, b, b, wide), now = see_plane(plane, b, c, wide);
    size_t seen = 0, forgotten = 0;
    for (size_t i = 0; i < now.depth.size(); ++i) {
        const glm::dvec2 uv((double(i % wide.width) + 0.5) / wide.width + now.motion[i][0],
                            (double(i / wide.width) + 0.5) / wide.height + now.motion[i][1]);
        if (!(now.depth[i] > 0) || uv.x < 0.02 || uv.y < 0.02 || uv.x > 0.98 || uv.y > 0.98) continue;
        const size_t j = size_t(uv.y * wide.height) * wide.width + size_t(uv.x * wide.width);
        const glm::dvec3 moved = glm::make_vec3(b.position.data()) - glm::make_vec3(c.position.data());
        const double expected = now.view_depth[i] + glm::dot(moved, glm::make_vec3(&c.world_from_view[6]));
        ++seen;
        forgotten += !(std::abs(before.view_depth[j] - expected) <= 0.01 * expected);
    }
    return share(forgotten, seen);
}

TEST_F(HardCase, AGrazingFloorKeepsItsHistoryToTheHorizon) {
    const auto camera = [](double f) {
        return looking({0, 0.01, -0.003 * f}, {0, 0.0095, -1 - 0.003 * f}, 1, wide, 0.001);
    };
    const auto before = [&](double f) { return camera(f - 1); };
    const double naive = naive_forgotten({}, camera), ours = ours_forgotten({}, camera, before);
    figure("case 7, share of a floor seen from 1 cm that is forgotten", naive, ours);
    EXPECT_LE(ours, 0.005);
    EXPECT_GT(naive, 0.05);
}

TEST_F(HardCase, AZoomKeepsItsHistory) {
    const auto camera = [](double f) { return looking({0, 1, 0}, {0, 0.6, -1}, 1 / (1 + 0.05 * f), wide); };
    const auto before = [&](double f) { return camera(f - 1); };
    // Naive: the previous view with the current projection, as if the lens had not changed.
    const auto same_lens = [&](double f) {
        Camera c = camera(f - 1);
        c.clip_from_view = camera(f).clip_from_view;
        return c;
    };
    const double naive = ours_forgotten({}, camera, same_lens), ours = ours_forgotten({}, camera, before);
    figure("case 11, share of a floor that is forgotten while zooming", naive, ours);
    EXPECT_LE(ours, 0.005);
    EXPECT_GT(naive, 0.05);
}

// A wall steps forward: all of its history is of what it hides, whatever its normals look like.
TEST_F(HardCase, NoNormalKeepsAForeignHistory) {
    const auto camera = looking({0, 0, 0}, {0, 0, -1}, 0.3, wide);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> across(-1, 1),
        towards(0.6f, 2);  // no normal that the camera cannot see
    size_t naive = 0;
    DenoiseRun run(denoiser(), wide, {"state"});
    for (uint32_t f = 0; f < 4; ++f) {
        PlaneImages images = see_plane({{0, 0, f < 3 ? -5.0 : -2.5}, {0, 0, 1}}, camera, camera, wide);
        for (auto& texel : images.normal) {
            glm::vec3 n(across(random), across(random), towards(random));
            n = glm::normalize(n);
            texel = to_half4({n.x, n.y, n.z, 0});
            // The published tolerance of a pixel that faces its viewer.
            if (f == 3) naive += std::isnan(std::pow(1.0f - (n.x * n.x + n.y * n.y + n.z * n.z), 7.9999f));
        }
        run.frame(images, noise(wide, f), frame_between(camera, camera, wide, f, f == 0));
    }
    const std::vector<float> count = run.kept_frames();
    const size_t ghosts = count_if(count, [](float c) { return c > 1.5f; });
    figure("case 8, share of pixels that keep what a wall hides", share(naive, count.size()),
           share(ghosts, count.size()));
    EXPECT_GT(naive, count.size() / 20);
    EXPECT_EQ(ghosts, 0u);
}

// Noise of mean 1/2 after eight frames: how much less of it is left on a steep plane than on one seen face
// on.
TEST_F(HardCase, ASteepPlaneIsFilteredLikeOneSeenFaceOn) {
    const auto samples = [](const CheckedPipeline& pipeline, double tilt_deg) {
        const double tilt = glm::radians(tilt_deg), distance = 200;
        const ViewedPlane plane{{0, 0, -distance}, {0, std::sin(tilt), std::cos(tilt)}};
        const Camera camera = looking({0, 0, 0}, {0, 0, -1}, 0.15, wide);
        DenoiseRun run(pipeline, wide, {});
        for (uint32_t f = 0; f < 8; ++f)
            run.frame(see_plane(plane, camera, camera, wide), noise(wide, f),
                      frame_between(camera, camera, wide, f, f == 0));
        double error = 0;
        for (const float v : run.plane("visibility")) error += (v - 0.5) * (v - 0.5);
        return 0.25 * wide.width * wide.height / error;
    };
    const double naive = samples(published_denoiser(), 85) / samples(published_denoiser(), 0);
    const double ours = samples(shipped_pipeline("denoise"), 85) / samples(shipped_pipeline("denoise"), 0);
    figure("case 10, N_eff at 85 degrees over face on", naive, ours);
    EXPECT_GT(ours, 0.5);
    EXPECT_LT(naive, 0.5);
}

}  // namespace
}  // namespace penumbra::test
