// SPDX-License-Identifier: MIT
// Whole shipped pipelines on a device: memory sharing, poison and repetition do not show in the picture, and
// any image size works.
#include <algorithm>

#include "app/outputs.h"
#include "app/session.h"
#include "host/images/texels.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_folder.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

std::unique_ptr<Session> open(const CheckedPipeline& pipeline, Shot shot, SessionOptions options) {
    options.size = shot.size;
    for (const std::string& name : pipeline.output_names())
        if (std::find(options.captures.begin(), options.captures.end(), name) == options.captures.end())
            options.captures.push_back(name);
    return open_session(pipeline, std::move(shot), options);
}

using Bytes = std::vector<std::byte>;

// Every captured resource of every frame, in order. A reset in the middle makes garbage history likelier to
// show.
std::vector<Bytes> run(const CheckedPipeline& pipeline, const Shot& shot, const SessionOptions& options,
                       uint32_t frames) {
    const auto session = open(pipeline, shot, options);
    std::vector<Bytes> result;
    for (uint32_t frame = 0; frame < frames; ++frame) {
        session->run_frame(frame, frame == 0 || frame == 5);
        for (const std::string& name : pipeline.output_names()) {
            const auto bytes = session->view().captured(name);
            result.emplace_back(bytes.begin(), bytes.end());
        }
    }
    return result;
}

void expect_memory_does_not_show(const CheckedPipeline& pipeline) {
    const Shot shot = plaza_shot({203, 117}, 8);
    SessionOptions plain;
    plain.alias = false;
    const std::vector<Bytes> expected = run(pipeline, shot, plain, 8);
    for (const uint32_t poison : {0u, 1u})
        for (const bool alias : {true, false}) {
            SessionOptions options;
            options.alias = alias;
            options.poison = poison;
            EXPECT_TRUE(run(pipeline, shot, options, 8) == expected)
                << "poison " << poison << " alias " << alias;
        }
}

class ShadowPipeline : public GpuTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(ShadowPipeline, AliasingAndPoisonDoNotShow) {
    expect_memory_does_not_show(shipped_pipeline(GetParam()));
}

TEST_P(ShadowPipeline, AnySizeGivesFiniteImagesInRange) {
    const CheckedPipeline pipeline = shipped_pipeline(GetParam());
    for (const std::array<uint32_t, 2> size :
         {std::array{1u, 1u}, {7u, 3u}, {8u, 4u}, {9u, 5u}, {17u, 1u}, {1919u, 1079u}}) {
        SCOPED_TRACE(testing::Message() << size[0] << "x" << size[1]);
        const auto session = open(pipeline, plaza_shot(size, 3), {});
        for (uint32_t frame = 0; frame < 3; ++frame) session->run_frame(frame, frame == 0);
        const TestFolder folder;
        OutputWriter writer(gpu(), folder);
        for (const std::string& name : pipeline.output_names()) writer.write(*session, name, 2);
        for (const WrittenOutput& output : writer.written()) {
            EXPECT_EQ(output.nonfinite, 0u) << output.resource;
            if (output.resource != "visibility") continue;
            EXPECT_GE(output.min, 0);
            EXPECT_LE(output.max, 1);
        }
    }
}

class TracedShadowPipeline : public ShadowPipeline {};

// Seen from above, the floor fills the view and faces the sun: every tile has undecided pixels. 129 600 tiles
// exceed what one dimension of an indirect dispatch may hold on many devices.
TEST_P(TracedShadowPipeline, EveryTileOfA4kFrameIsTraced) {
    const CheckedPipeline pipeline = shipped_pipeline(GetParam());
    Shot shot = plaza_shot({3840, 2160}, 1);
    shot.camera = {{0, {0, 6, 0.01}, {0, 0, 0}, {0, 1, 0}}};
    const auto session = open(pipeline, shot, {});
    const FrameCost cost = session->run_frame(0, true);
    std::map<std::string, uint32_t> counters;
    for (size_t p = 0; p < session->plan().passes.size(); ++p) {
        const PlanPass& pass = session->plan().passes[p];
        for (size_t i = 0; i < cost.passes[p].counters.size(); ++i)
            counters[pass.counters[i]] = cost.passes[p].counters[i];
    }
    EXPECT_EQ(counters.at("tiles_listed"), 480u * 540u);
    EXPECT_EQ(counters.at("receivers"), 3840u * 2160u);
    EXPECT_EQ(counters.at("rays"), counters.at("unknown"));
    EXPECT_GT(counters.at("rays"), 3840u * 2160u * 9 / 10);
}

class ShadowsSky : public GpuTest {};

// Where there is no surface there is no shadow, also in blocks whose surfaces are all in shadow.
TEST_F(ShadowsSky, IsLit) {
    Shot shot = plaza_shot({160, 96}, 3);
    shot.camera = {{0, {0.5, 0.4, 1.2}, {-0.8, 0.9, -1}, {0, 1, 0}}};  // past the block's shadowed side, up
    SessionOptions options;
    options.captures = {"view_depth"};
    const auto session = open(shipped_pipeline("shadows"), shot, options);
    size_t sky = 0, dark = 0;
    for (uint32_t frame = 0; frame < 3; ++frame) {
        session->run_frame(frame, frame == 0);
        const auto depth = session->view().captured("view_depth"),
                   visibility = session->view().captured("visibility");
        const PlanarImage z = decode_texels(Format::r32f, 160, 96, depth, {"Z"});
        const PlanarImage v = decode_texels(Format::r16f, 160, 96, visibility, {"Y"});
        for (size_t i = 0; i < z.planes[0].values.size(); ++i) {
            dark += v.planes[0].values[i] == 0;
            if (z.planes[0].values[i] > 0) continue;
            ++sky;
            ASSERT_EQ(v.planes[0].values[i], 1) << "pixel " << i << " of frame " << frame;
        }
    }
    EXPECT_GT(sky, 1000u);
    EXPECT_GT(dark, 1000u);
}

INSTANTIATE_TEST_SUITE_P(Pipelines, ShadowPipeline,
                         ::testing::Values("raw", "many_rays", "fidelityfx", "shadows", "covered",
                                           "hybrid_shadows", "sigma"),
                         [](const auto& test) { return std::string(test.param); });
INSTANTIATE_TEST_SUITE_P(Pipelines, TracedShadowPipeline,
                         ::testing::Values("raw", "fidelityfx", "one_ray", "sigma"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace penumbra::test
