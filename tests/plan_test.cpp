// SPDX-License-Identifier: MIT
// Every plan of every shipped pipeline, at five sizes: nothing overlaps in bytes and time, every access is
// ordered after what it depends on, the heap is within 2 % of the smallest possible one. The checks share no
// code with the compiler, and mutations of a plan show that they see what they are for.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "penumbra/graph.h"
#include "tests/golden_text.h"
#include "tests/plan_checks.h"
#include "tests/shipped.h"
#include "tests/toy_set.h"

namespace penumbra::test {
namespace {

const std::filesystem::path root = PENUMBRA_SOURCE_DIR;
constexpr Extent sizes[] = {{1280, 720}, {1920, 1080}, {2560, 1440}, {3840, 2160}, {333, 777}};

Plan plan_of(const CheckedPipeline& pipeline, Extent extent, bool alias = true, Facts facts = {}) {
    Target target;
    target.extent = extent;
    target.facts = std::move(facts);
    target.inputs = told_inputs(pipeline);
    target.device = reference_device();
    CompileOptions options;
    options.alias = alias;
    options.optimum_search_nodes = 1'000'000;
    Diagnostics diagnostics;
    auto plan = compile(pipeline, target, options, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::move(*plan);
}

class ShippedPlan : public ::testing::TestWithParam<std::string> {};

TEST_P(ShippedPlan, NothingOverlapsInBytesAndTime) {
    for (const Extent extent : sizes)
        for (const bool alias : {true, false})
            EXPECT_EQ(overlap_errors(plan_of(shipped_pipeline(GetParam()), extent, alias)),
                      std::vector<std::string>{});
}

TEST_P(ShippedPlan, EveryAccessIsOrderedAfterWhatItDependsOn) {
    for (const bool alias : {true, false})
        EXPECT_EQ(hazard_errors(plan_of(shipped_pipeline(GetParam()), sizes[0], alias)),
                  std::vector<std::string>{});
}

TEST_P(ShippedPlan, HeapIsWithinTwoPercentOfTheOptimum) {
    for (const Extent extent : sizes) {
        const MemoryReport memory = plan_of(shipped_pipeline(GetParam()), extent).memory;
        // Where the search does not end or was not worth its while, the bound that no packing can be below.
        const uint64_t least = memory.optimum_bytes.value_or(memory.live_bound_bytes);
        EXPECT_LE(memory.live_bound_bytes, least);
        EXPECT_LE(static_cast<double>(memory.heap_bytes), 1.02 * static_cast<double>(least))
            << extent.width << "x" << extent.height;
        EXPECT_LE(memory.heap_bytes, memory.unaliased_bytes);
    }
}

TEST_P(ShippedPlan, EqualsItsGoldenText) {
    expect_golden(to_text(plan_of(shipped_pipeline(GetParam()), {1920, 1080})),
                  root / "tests/golden/plans" / (GetParam() + ".txt"));
}

// Mesa 22's llvmpipe writes beyond an array where a branch follows from the fifth uniform buffer
// (graph/interface.h).
TEST_P(ShippedPlan, ReadsItsBlocksBeforeTheFifth) {
    for (const PlanPass& pass : plan_of(shipped_pipeline(GetParam()), sizes[0]).passes) {
        std::map<std::pair<uint32_t, uint32_t>, BindingSource> blocks;
        for (const PlanBinding& b : pass.bindings)
            if (b.type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER) blocks[{b.set, b.binding}] = b.source;
        size_t last_read = 0, at = 0;
        for (const auto& [place, source] : blocks)
            if (++at; source != BindingSource::nothing) last_read = at;
        EXPECT_LE(last_read, 4u) << pass.node;
    }
}

INSTANTIATE_TEST_SUITE_P(Pipelines, ShippedPlan, ::testing::ValuesIn(pipeline_files()),
                         [](const auto& test) { return test.param; });

TEST(ToyPlans, AreOrderedAndDoNotOverlap) {
    const CheckedPipeline toys = toy_pipeline_file();
    for (const bool moves : {true, false})
        for (const bool alias : {true, false}) {
            const Plan plan = plan_of(toys, {64, 48}, alias, {{"moves", moves}});
            EXPECT_EQ(overlap_errors(plan), std::vector<std::string>{});
            EXPECT_EQ(hazard_errors(plan), std::vector<std::string>{});
        }
}

// Each resource's bytes are reserved for as long as they are needed: moved onto another live resource it is
// noticed.
TEST(Mutation, EveryResourceMovedOntoANeighbourIsNoticed) {
    const CheckedPipeline pipeline = shipped_pipeline("fidelityfx");
    const Plan plan = plan_of(pipeline, sizes[0]);
    for (size_t r = 0; r < plan.resources.size(); ++r)
        for (size_t other = 0; other < plan.resources.size(); ++other) {
            const PlanResource &a = plan.resources[r], &b = plan.resources[other];
            const bool live_together =
                a.first_pass < b.first_pass + b.length && b.first_pass < a.first_pass + a.length;
            if (r == other || a.heap != b.heap || !live_together) continue;
            Plan mutated = plan;
            mutated.resources[r].offset[0] = mutated.resources[other].offset[0];
            EXPECT_NE(overlap_errors(mutated), std::vector<std::string>{})
                << a.names[0] << " onto " << b.names[0];
        }
}

TEST(Compile, AFormatThatNoReaderAcceptsNamesTheInput) {
    Target target;
    target.extent = {64, 64};
    target.device = reference_device();
    target.inputs["depth"] = {Format::rgba8, target.extent};
    Diagnostics diagnostics;
    EXPECT_FALSE(compile(shipped_pipeline("raw"), target, {}, diagnostics));
    EXPECT_NE(diagnostics.text().find("\"depth\" as rgba8"), std::string::npos) << diagnostics.text();
}

TEST(Compile, AFrameBeyondTheDeviceIsAnError) {
    Target target;
    target.extent = {20000, 64};
    target.device = reference_device();
    Diagnostics diagnostics;
    EXPECT_FALSE(compile(shipped_pipeline("raw"), target, {}, diagnostics));
    EXPECT_NE(diagnostics.text().find("exceeds the device's largest image"), std::string::npos)
        << diagnostics.text();
}

TEST(Compile, AnUnknownCaptureIsAnErrorWithASuggestion) {
    Target target;
    target.extent = {64, 64};
    target.device = reference_device();
    CompileOptions options;
    options.captures = {"visibilty"};
    Diagnostics diagnostics;
    EXPECT_FALSE(compile(shipped_pipeline("raw"), target, options, diagnostics));
    EXPECT_NE(diagnostics.text().find("did you mean \"visibility\"?"), std::string::npos)
        << diagnostics.text();
}

TEST(FrameBlock, ReprojectionDoesNotDependOnTheDistanceFromTheOrigin) {
    const auto block_at = [](double offset) {
        FrameDescription frame;
        frame.camera.clip_from_view = frame.previous.clip_from_view = perspective(1.0, 16.0 / 9, 0.1);
        frame.camera.position = {offset + 0.25, 1, 2};
        frame.previous.position = {offset, 1, 2};
        frame.size = {1920, 1080};
        return make_frame_block(frame);
    };
    const FrameBlock near = block_at(0), far = block_at(1e7);
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r)
            EXPECT_NEAR(near.prev_clip_from_rel.columns[c][r], far.prev_clip_from_rel.columns[c][r], 1e-7);
    EXPECT_FLOAT_EQ(far.camera_delta.v[0], -0.25f);
}

// As where an engine renders fewer columns than it shows.
TEST(FrameBlock, APixelSpansItsLongerSide) {
    FrameDescription frame;
    frame.camera.clip_from_view = perspective(1.0, 16.0 / 9, 0.1);
    const auto span = [&](uint32_t width, uint32_t height) {
        frame.size = {width, height};
        return make_frame_block(frame).pixel_angle;
    };
    const float square = span(1920, 1080);
    EXPECT_NEAR(span(960, 1080), 2 * square, 1e-6 * square);
    EXPECT_NEAR(span(1920, 540), 2 * square, 1e-6 * square);
    EXPECT_NEAR(span(1920, 2160), square, 1e-6 * square);
}

TEST(FrameBlock, AnOrthographicPastHasPlanesOfItsOwn) {
    const auto far_at = [](double far_m) {
        std::array<double, 16> clip_from_view{};
        clip_from_view[0] = clip_from_view[5] = 0.1;
        clip_from_view[10] = 1 / (far_m - 1);
        clip_from_view[14] = far_m / (far_m - 1);
        clip_from_view[15] = 1;
        return clip_from_view;
    };
    FrameDescription frame;
    frame.camera.clip_from_view = far_at(200);
    frame.previous.clip_from_view = far_at(100);
    frame.flags = frame_orthographic;
    frame.size = {64, 64};
    const FrameBlock block = make_frame_block(frame);
    const double z = block.prev_clip_from_rel.columns[2][2] * -7.0 + block.prev_clip_from_rel.columns[3][2];
    EXPECT_NEAR(-(block.prev_depth.v[0] * z + block.prev_depth.v[1]), 7, 1e-4);
}

}  // namespace
}  // namespace penumbra::test
