// SPDX-License-Identifier: MIT
// The active size of a frame, which is at most the plan's: a plan for a larger one gives the same images to
// the bit, and what was accumulated before the size changed is worth as much behind it.
#include <algorithm>
#include <cstring>

#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_pipeline.h"
#include "tests/shot_run.h"
#include "tests/sized_run.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr std::array<uint32_t, 2> size{75, 43}, largest{96, 54};

class SizeGpu : public GpuTest, public ::testing::WithParamInterface<std::string> {};

using Outputs = std::vector<std::map<std::string, Bytes>>;  // by frame

Outputs run(const std::string& name, std::array<uint32_t, 2> of_size,
            std::optional<std::array<uint32_t, 2>> in, uint32_t frames) {
    const Shot shot = plaza_shot(of_size, frames);
    const CheckedPipeline pipeline = pipeline_for(shot, name);
    SessionOptions options;
    options.size = of_size;
    options.largest = in;
    options.captures = pipeline.output_names();
    options.poison = 0;  // what lies outside of the frame is no number
    options.pass_costs = false;
    options.cascade_size = 64;
    const auto session = open_session(pipeline, shot, options, test_nodes());
    Outputs outputs(frames);
    for (uint32_t f = 0; f < frames; ++f) {
        session->run_frame(f, f == 0);
        for (const PlanOutput& output : session->plan().outputs)
            outputs[f][output.name] =
                cropped(session->plan(), output.name, session->view().captured(output.name),
                        {of_size[0], of_size[1]});
    }
    return outputs;
}

// Nothing that a frame reads or writes depends on the plan's size: neither what lies beside the frame (which
// is no number here) nor where in the whole of an image a texel of it lies.
TEST_P(SizeGpu, APlanForMoreGivesTheSameImages) {
    const Outputs expected = run(GetParam(), size, {}, 3), larger = run(GetParam(), size, largest, 3);
    for (size_t f = 0; f < expected.size(); ++f)
        for (const auto& [name, bytes] : expected[f])
            EXPECT_TRUE(larger[f].at(name) == bytes) << name << " of frame " << f;
    EXPECT_NE(expected[0], expected[2]) << "nothing changes: the test shows nothing";
}

INSTANTIATE_TEST_SUITE_P(Shipped, SizeGpu, ::testing::ValuesIn(rendering_pipeline_files()),
                         [](const auto& name) { return name.param; });

class SizeChangeGpu : public GpuTest {};

// What the host brings lies in larger images, beside garbage.
TEST_F(SizeChangeGpu, WhatLiesBesideTheFrameIsNotRead) {
    for (const char* name : {"shadows", "hybrid_shadows"}) {
        const CheckedPipeline pipeline = shipped_pipeline(name);
        const Recording recording = record(pipeline, plaza_shot(size, 3), 3, recorded_facts());
        SizedRun run(pipeline, {largest[0], largest[1]}, recording.plan);
        for (size_t f = 0; f < 3; ++f) {
            run.frame(recording.frames[f], f ? &recording.frames[f - 1] : nullptr);
            for (const auto& [output, bytes] : recording.frames[f].outputs)
                EXPECT_TRUE(run.output(output) == bytes) << name << ": " << output << " of frame " << f;
        }
    }
}

// Rays per pixel that would be as far from the truth.
double n_eff(const Bytes& bytes, const Truth& truth) {
    std::vector<float> values(bytes.size() / 2);
    for (size_t i = 0; i < values.size(); ++i) {
        uint16_t half = 0;
        std::memcpy(&half, &bytes[2 * i], 2);
        values[i] = from_half(half);
    }
    return n_eff_of_receivers(values, truth);
}

Shot shipped_shot(const char* name, std::array<uint32_t, 2> of_size, bool still) {
    Shot shot = shot_named(name, of_size);
    if (still) shot.camera.resize(1);
    return shot;
}

// Masks that are kept know the frame's size, but a smaller frame writes over some tiles' and leaves others'.
TEST_F(SizeChangeGpu, MasksFromBeforeASmallerFrameAreNotTakenOver) {
    constexpr uint32_t small = 18, back = 20, frames = 40;  // the jitter comes back after sixteen
    constexpr std::array<uint32_t, 2> whole{96, 56}, low{96, 24};
    Shot shot = shipped_shot("colonnade", whole, true);
    auto& keys = shot.objects.at("gate").keys;
    keys = {keys.front(), keys.back()};
    keys[0].frame = small;  // its shadow goes while frames are small
    keys[1].frame = small + 1;
    const CheckedPipeline pipeline = pipeline_for(
        shot, "hybrid_shadows",
        {R"(outputs=["visibility"])", "inputs.moved_boxes.optional=false",
         R"(nodes.reuse={ "type": "reuse", "if": "sun_disc & tree", "in": { "decided_hits": "facing_hits", "whole_masks_prev": "whole_masks@-1" } })",
         R"(nodes.retain={ "type": "retain", "if": "sun_disc & tree", "in": { "whole_masks_prev": "whole_masks@-1" } })"});
    const Recording own = record(pipeline, shot, frames, recorded_facts());
    shot.size = low;
    const Recording lower = record(pipeline, shot, back, recorded_facts());
    SizedRun run(pipeline, {whole[0], whole[1]}, own.plan);
    const RecordedFrame* last = nullptr;
    for (uint32_t f = 0; f < frames; ++f) {
        const RecordedFrame& frame = f >= small && f < back ? lower.frames[f] : own.frames[f];
        run.frame(frame, last);
        last = &frame;
        EXPECT_TRUE(run.output("visibility") == frame.outputs.at("visibility")) << "frame " << f;
    }
}

struct Change {
    const char* shot;
    bool still;
    std::array<uint32_t, 2> before, after;
};

class HistoryGpu : public GpuTest, public ::testing::WithParamInterface<Change> {};

// N_eff of the frame at which the size changes and of one a little later, beside that before the change, and
// of the same frames without a past and with one of their own size: single frames, which move by a tenth
// with anything that turns a ray. Where nothing moves, pixels keep a past
// of their own, which those of another size do not have: the frame is as one without a past, and rays are
// allotted as to one.
TEST_P(HistoryGpu, SurvivesAChangeOfSize) {
    constexpr uint32_t change = 16, frames = change + 5;
    const auto& [name, still, before, after] = GetParam();
    const CheckedPipeline pipeline = shipped_pipeline("shadows");
    const Facts facts =
        still ? Facts{{"alpha", false}, {"translucent", false}, {"moves", false}, {"sun_moves", false}}
              : recorded_facts();
    const Recording old = record(pipeline, shipped_shot(name, before, still), change, facts, false),
                    own = record(pipeline, shipped_shot(name, after, still), frames, facts, false);
    const Extent most{std::max(before[0], after[0]), std::max(before[1], after[1])};
    SizedRun changed(pipeline, most, own.plan), anew(pipeline, most, own.plan);
    for (uint32_t f = 0; f < change; ++f) changed.frame(old.frames[f], f ? &old.frames[f - 1] : nullptr);
    std::printf(
        "%s%s, %ux%u to %ux%u: N_eff %.2f before\n", name, still ? " (still)" : "", before[0], before[1],
        after[0], after[1],
        n_eff(changed.output("visibility"), truth_of(shipped_shot(name, before, still), change - 1, 144)));
    for (uint32_t f = change; f < frames; ++f) {
        changed.frame(own.frames[f], f == change ? &old.frames[f - 1] : &own.frames[f - 1]);
        anew.frame(own.frames[f], f == change ? nullptr : &own.frames[f - 1]);
        EXPECT_EQ(changed.view().reset().reason, Reset::Reason::none);
        if (f != change && f + 1 != frames) continue;
        const Truth truth = truth_of(shipped_shot(name, after, still), f, 144);
        const double kept = n_eff(changed.output("visibility"), truth),
                     reset = n_eff(anew.output("visibility"), truth),
                     ideal = n_eff(own.frames[f].outputs.at("visibility"), truth);
        std::printf("frame %+d: N_eff %.2f; without a past %.2f, with one of its own size %.2f\n",
                    int(f) - int(change), kept, reset, ideal);
        if (still) {
            EXPECT_TRUE(changed.output("visibility") == anew.output("visibility"));
            continue;
        }
        if (f == change) {
            EXPECT_GT(kept, 1.1 * reset);
        }
        EXPECT_GT(kept, 0.4 * ideal);
    }
}

INSTANTIATE_TEST_SUITE_P(Shots, HistoryGpu,
                         ::testing::Values(Change{"colonnade", false, {128, 72}, {160, 90}},
                                           Change{"colonnade", false, {160, 90}, {112, 63}},
                                           Change{"colonnade", true, {128, 72}, {160, 90}}),
                         [](const auto& test) {
                             return std::string(test.param.shot) + (test.param.still ? "_still" : "") +
                                    (test.param.after[0] > test.param.before[0] ? "_up" : "_down");
                         });

}  // namespace
}  // namespace penumbra::test
