// SPDX-License-Identifier: MIT
// denoise_radiance.json, for hosts that trace by themselves: on radiance_rays' own rays as if they were a
// host's.
#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <optional>

#include "host/models/model_builder.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"
#include "tests/shipped.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

class DenoiseRadiance : public GpuTest {};

constexpr uint32_t frames = 5;

Shot moving_shot() {
    Shot shot = night_shot(striped_floor({0, 0.1f, 0.3f, 0.8f}), {56, 32}, frames);
    shot.camera.push_back({frames - 1, {0.4, 1.4, 2.8}, {0.1, 0, 0}, {0, 1, 0}});
    shot.environment = linear_sky(0.2, 2);
    return shot;
}

// What the host's rays become after some frames, and what their own pipeline makes of them. `turned`: each
// direction is that of another pixel.
struct Images {
    std::vector<float> foreign, own;
};
// `wrong`: what one pixel of the last frame but two has for radiance.
Images run(bool turned, std::optional<float> wrong = {}) {
    const Shot shot = moving_shot();
    const auto session =
        open_shipped("reflections", shot,
                     {"nodes.rays.params.hit_normals=false", "nodes.reconnect.params.hit_normals=false"},
                     {"radiance", "ray_direction"});
    ViewRun host(shipped_pipeline("denoise_radiance"), {shot.size[0], shot.size[1]}, radiance_host_options());
    for (uint32_t frame = 0; frame < frames; ++frame) {
        session->run_frame(frame, frame == 0);
        hand_over_guides(host, *session);
        auto radiance = captured<uint16_t>(session->view(), "radiance");
        if (wrong && frame == frames - 3) radiance[4 * (20 * shot.size[0] + 28)] = glm::packHalf1x16(*wrong);
        host.set("radiance", radiance);
        auto directions = captured<uint32_t>(session->view(), "ray_direction");
        if (turned) std::rotate(directions.begin(), directions.begin() + 1, directions.end());
        host.set("ray_direction", directions);
        host.frame(session->frame_description());
    }
    return {captured_planes(host.view(), "specular").at(0),
            captured_planes(session->view(), "specular").at(0)};
}

TEST_F(DenoiseRadiance, OfOurRaysIsTheirPipeline) {
    const Images images = run(false);
    EXPECT_TRUE(images.foreign == images.own);
    EXPECT_GT(*std::ranges::max_element(images.own), 0.1f);
}

TEST_F(DenoiseRadiance, KnowsWhereRaysWent) {
    const Images images = run(true);
    EXPECT_FALSE(images.foreign == images.own);
}

// One pixel that is no number is as good as none.
TEST_F(DenoiseRadiance, WhatIsNoNumberIsNoRay) {
    const std::vector<float> right = run(false).foreign;
    const float largest = *std::ranges::max_element(right);
    for (const float wrong : {INFINITY, NAN}) {
        const std::vector<float> image = run(false, wrong).foreign;
        for (size_t i = 0; i < image.size(); ++i)
            ASSERT_LT(std::abs(image[i] - right[i]), 0.2f * largest) << i;
    }
}

// A mirror before a camera at rest, of which each column shows something else: what it mirrors was seen by
// the same pixel, also by a camera whose rays are parallel.
TEST_F(DenoiseRadiance, AMirrorsPastIsThePixelsOwn) {
    constexpr Extent extent{96, 64};
    constexpr size_t pixels = extent.width * extent.height;
    constexpr double mirror_m = 50, near_m = 10, far_m = 100;
    const double x = 2 / (0.1 * extent.width), y = 2 / (0.1 * extent.height);  // pixels of 10 cm there
    for (const bool parallel : {false, true}) {
        SCOPED_TRACE(parallel);
        Camera camera = camera_at({0, 0, mirror_m}, 0, extent);
        camera.near_m = near_m;
        if (parallel)
            camera.clip_from_view = {
                x, 0, 0, 0, 0, -y, 0, 0, 0, 0, 1 / (far_m - near_m), 0, 0, 0, far_m / (far_m - near_m), 1};
        else
            camera.clip_from_view = {x * mirror_m, 0, 0, 0,      0, -y * mirror_m, 0, 0, 0, 0, 0,
                                     -1,           0, 0, near_m, 0};
        ViewRunOptions options = radiance_host_options();
        options.captures = {"past_image", "past_surface", "past_frames"};
        ViewRun host(shipped_pipeline("denoise_radiance"), extent, options);
        std::vector<float> normal(4 * pixels);
        std::vector<uint16_t> radiance(4 * pixels, glm::packHalf1x16(4));  // of which w is the distance
        std::vector<uint32_t> direction(pixels);
        for (size_t i = 0; i < pixels; ++i) {
            normal[4 * i + 2] = 1;
            const double column = double(i % extent.width), row = double(i / extent.width);
            for (size_t c = 0; c < 3; ++c)
                radiance[4 * i + c] = glm::packHalf1x16(float(1 + 0.8 * std::sin(column / 4)));
            const glm::dvec3 seen((column + 0.5) * 0.1 - 4.8, 3.2 - (row + 0.5) * 0.1, -mirror_m);
            const glm::dvec3 mirrored = parallel ? glm::dvec3(0, 0, 1) : glm::dvec3(seen.x, seen.y, -seen.z);
            const glm::dvec3 octahedral =
                mirrored / (std::abs(mirrored.x) + std::abs(mirrored.y) + std::abs(mirrored.z));
            direction[i] = glm::packSnorm2x16(glm::vec2(octahedral));
        }
        host.set("depth", std::vector<float>(pixels, float(parallel ? (far_m - mirror_m) / (far_m - near_m)
                                                                    : near_m / mirror_m)));
        host.set("normal", normal);
        host.set("motion", std::vector<uint16_t>(4 * pixels));
        host.set("material", std::vector<uint16_t>(pixels, 0x14ff));  // a metal of roughness .08
        host.set("radiance", radiance);
        host.set("ray_direction", direction);
        for (uint32_t frame = 0; frame < 3; ++frame) {
            FrameDescription description = frame_between(camera, camera, extent, frame, frame == 0);
            if (parallel) description.flags |= frame_orthographic;
            host.frame(description);
        }
        const auto known = captured<uint16_t>(host.view(), "past_frames");
        EXPECT_TRUE(std::ranges::all_of(known, [](uint16_t bytes) { return (bytes >> 8 & 31) > 0; }));
        EXPECT_EQ(captured<uint32_t>(host.view(), "past_image"),
                  captured<uint32_t>(host.view(), "past_surface"));
    }
}

}  // namespace
}  // namespace penumbra::test
