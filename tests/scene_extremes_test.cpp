// SPDX-License-Identifier: MIT
// Scenes that need less than everything, rendered: the shorter plans give what the long ones would, to the
// bit where that is what they promise, and share memory as safely.
#include <algorithm>
#include <filesystem>
#include <fstream>

#include "app/session.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_folder.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr std::array<uint32_t, 2> size{203, 117};

std::unique_ptr<Session> open(const std::string& pipeline, Shot shot, SessionOptions options) {
    options.size = shot.size;
    options.captures = {"visibility", "view_depth", pipeline == "raw" ? "lit" : "color"};
    return open_session(shipped_pipeline(pipeline), std::move(shot), options);
}

SessionOptions with_facts(Facts facts) {
    SessionOptions options;
    options.facts = std::move(facts);
    return options;
}

std::vector<float> visibility_of(const Session& session) {
    return captured_planes(session.view(), "visibility").at(0);
}

// Pixels that differ between two sessions' images, in any channel.
size_t differing(const Session& a, const Session& b, const std::string& name, size_t channels = 4) {
    const auto left = captured_planes(a.view(), name), right = captured_planes(b.view(), name);
    size_t count = 0;
    for (size_t i = 0; i < left[0].size(); ++i)
        for (size_t c = 0; c < std::min(left.size(), channels); ++c)
            if (left[c][i] != right[c][i]) {
                ++count;
                break;
            }
    return count;
}

bool traces(const Session& session) {
    return std::ranges::any_of(session.plan().passes, [](const PlanPass& pass) {
        return std::ranges::find(pass.counters, "rays") != pass.counters.end();
    });
}

Shot still_plaza(uint32_t frames) {
    Shot shot = plaza_shot(size, frames);
    shot.camera.resize(1);
    shot.sun.resize(1);
    shot.objects.clear();
    return shot;
}

class SceneExtremes : public GpuTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(SceneExtremes, BelowTheHorizonNothingIsLitAndNoRayIsSent) {
    Shot shot = plaza_shot(size, 3);
    for (SunKey& key : shot.sun) key.to_sun = {0.4, -0.05, 0.2};
    const auto session = open(GetParam(), shot, {});
    EXPECT_FALSE(traces(*session));
    for (uint32_t frame = 0; frame < 3; ++frame) {
        session->run_frame(frame, frame == 0);
        for (const float v : visibility_of(*session)) ASSERT_EQ(v, 0);
    }
}

TEST_P(SceneExtremes, WhereNothingCastsAllIsLitAndNoRayIsSent) {
    const auto session = open(GetParam(), plaza_shot(size, 3), with_facts({{"casters", false}}));
    EXPECT_FALSE(traces(*session));
    for (uint32_t frame = 0; frame < 3; ++frame) {
        session->run_frame(frame, frame == 0);
        for (const float v : visibility_of(*session)) ASSERT_EQ(v, 1);
    }
}

TEST_P(SceneExtremes, AnEmptySceneIsRefused) {
    const TestFolder folder;
    const std::filesystem::path file = folder / "empty.gltf";
    std::ofstream(file) << R"({ "asset": { "version": "2.0" }, "nodes": [{ "name": "nothing" }],
                                "scenes": [{ "nodes": [0] }], "scene": 0 })";
    Shot shot = still_plaza(2);
    shot.model = file;
    EXPECT_THROW(open(GetParam(), shot, {}), std::runtime_error);
}

INSTANTIATE_TEST_SUITE_P(Pipelines, SceneExtremes, ::testing::Values("raw", "shadows"),
                         [](const auto& test) { return std::string(test.param); });

class PointSun : public GpuTest {};

// Motion included: every frame is the hard shadow of its own G-buffer, without a memory of the frames before.
TEST_F(PointSun, GivesTheHardShadowOfTheRaysToTheBit) {
    Shot shot = plaza_shot(size, 4);
    shot.sun_angular_radius_deg = 0;
    SessionOptions still_raster;  // raw.json has no anti-aliasing and is not jittered either
    still_raster.jitter = false;
    const auto shadows = open("shadows", shot, still_raster), raw = open("raw", shot, {});
    const auto general =
        open("raw", shot, with_facts({{"sun_disc", true}}));  // noise over a disc of no extent
    size_t dark = 0;
    for (uint32_t frame = 0; frame < 4; ++frame) {
        for (const auto& session : {&shadows, &raw, &general}) (*session)->run_frame(frame, frame == 0);
        const std::vector<float> v = visibility_of(*shadows);
        for (const float x : v) {
            ASSERT_TRUE(x == 0 || x == 1) << x;
            dark += x == 0;
        }
        EXPECT_EQ(differing(*shadows, *general, "visibility"), 0u) << frame;
        EXPECT_EQ(differing(*raw, *general, "visibility"), 0u) << frame;
    }
    EXPECT_GT(dark, 1000u);
}

class StillScene : public GpuTest {};

// Without jitter a still pixel shows one point for ever: reprojection finds it where it is. (The denoiser of
// shadows.json has another picture there: it doubts no past where nothing can have moved.)
TEST_F(StillScene, NeedsNoMotionForTheSamePicture) {
    SessionOptions options;
    options.jitter = false;
    SessionOptions general = with_facts({{"moves", true}});
    general.jitter = false;
    const auto brief = open("hybrid_shadows", still_plaza(8), options),
               full = open("hybrid_shadows", still_plaza(8), general);
    EXPECT_LT(brief->plan().memory.heap_bytes, full->plan().memory.heap_bytes);
    for (uint32_t frame = 0; frame < 8; ++frame) {
        brief->run_frame(frame, frame == 0);
        full->run_frame(frame, frame == 0);
        EXPECT_EQ(differing(*brief, *full, "visibility"), 0u) << frame;
        // Reprojection also forgets: where a pixel is neither on its neighbours' nearest surface nor on the
        // farthest. (Not the fourth channel, in which a texel remembers whether it moved.)
        EXPECT_LE(differing(*brief, *full, "color", 3), size[0] * size[1] / 1000) << frame;
    }
}

class ShorterPlans : public GpuTest {};

// Every shorter plan shares its memory without a trace: shot and facts of each, with a reset in the middle.
TEST_F(ShorterPlans, ShareMemoryWithoutATrace) {
    Shot point = still_plaza(8), night = plaza_shot(size, 8), moving_point = plaza_shot(size, 8);
    point.sun_angular_radius_deg = moving_point.sun_angular_radius_deg = 0;
    for (SunKey& key : night.sun) key.to_sun = {0.4, -0.05, 0.2};
    const std::vector<std::pair<const char*, Shot>> shots = {
        {"still", still_plaza(8)}, {"point", point}, {"moving point", moving_point}, {"night", night}};
    for (const auto& [name, shot] : shots) {
        const auto run = [&, &scene = shot](bool alias, std::optional<uint32_t> poison) {
            SessionOptions options;
            options.alias = alias;
            options.poison = poison;
            const auto session = open("shadows", scene, options);
            std::vector<std::vector<std::byte>> frames;
            for (uint32_t frame = 0; frame < 8; ++frame) {
                session->run_frame(frame, frame == 0 || frame == 5);
                for (const char* output : {"visibility", "color"}) {
                    const auto bytes = session->view().captured(output);
                    frames.emplace_back(bytes.begin(), bytes.end());
                }
            }
            return frames;
        };
        const auto expected = run(false, {});
        for (const uint32_t poison : {0u, 1u})
            EXPECT_TRUE(run(true, poison) == expected) << name << ", poison " << poison;
    }
}

}  // namespace
}  // namespace penumbra::test
