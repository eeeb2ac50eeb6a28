// SPDX-License-Identifier: MIT
// The active size of a frame, which is at most the plan's: a plan for a larger one gives the same images to the bit, and what
// was accumulated before the size changed is worth as much behind it.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/gtc/packing.hpp>

#include "app/session.h"
#include "app/truth.h"
#include "host/images/texels.h"
#include "tests/gpu_test.h"
#include "tests/sized_run.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr Extent largest{96, 54};
constexpr std::array<uint32_t, 2> size{75, 43};

class SizeGpu : public GpuTest, public ::testing::WithParamInterface<const char*> {};

using Outputs = std::vector<std::map<std::string, Bytes>>;  // by frame

Outputs run(const CheckedPipeline& pipeline, bool in_larger_plan, uint32_t frames) {
    SessionOptions options;
    options.size = size;
    if (in_larger_plan) options.largest = {largest.width, largest.height};
    options.captures = pipeline.output_names();
    options.poison = 0;  // what lies outside of the frame is no number
    options.optimum = options.pass_costs = false;
    options.cascade_size = 64;
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto session = Session::open(gpu(), test_nodes(), pipeline, plaza_shot(size, frames), options,
                                       diagnostics, warnings);
    if (!session) throw std::runtime_error(diagnostics.text());
    Outputs outputs(frames);
    for (uint32_t f = 0; f < frames; ++f) {
        session->run_frame(f, f == 0);
        for (const PlanOutput& output : session->plan().outputs)
            outputs[f][output.name] = cropped(session->plan(), output.name,
                                              session->view().captured(output.name), {size[0], size[1]});
    }
    return outputs;
}

double largest_difference(const CheckedPipeline& pipeline, const std::string& name, const Bytes& a, const Bytes& b) {
    const auto output = std::ranges::find_if(pipeline.outputs, [&](uint32_t id) { return pipeline.resources[id].name == name; });
    const Format format = pipeline.resources[*output].format;
    const PlanarImage x = decode_texels(format, size[0], size[1], a, {"x", "y", "z", "w"}),
                      y = decode_texels(format, size[0], size[1], b, {"x", "y", "z", "w"});
    double most = 0; int n=0;
    for (size_t p = 0; p < x.planes.size(); ++p)
        for (size_t i = 0; i < x.planes[p].values.size(); ++i)
            n += x.planes[p].values[i] != y.planes[p].values[i], most = std::max(most, std::abs(double(x.planes[p].values[i]) - double(y.planes[p].values[i])));
    printf("%s: %d differ, most %g\n", name.c_str(), n, most);
    return most;
}

// A linear sampler is told where in the whole image a texel lies, and rounds that: what taa makes of its history, and the
// denoiser of fidelityfx.json, is off by so much from the second frame on. All else is the same to the bit.
TEST_P(SizeGpu, APlanForMoreGivesTheSameImages) {
    const std::string pipeline_name = GetParam();
    const CheckedPipeline pipeline = shadow_pipeline_file(pipeline_name);
    const Outputs expected = run(pipeline, false, 3), larger = run(pipeline, true, 3);
    const bool filters = pipeline_name.ends_with("fidelityfx");
    for (size_t f = 0; f < expected.size(); ++f)
        for (const auto& [name, bytes] : expected[f])
            if (f > 0 && (name == "color" || filters))
                EXPECT_LT(largest_difference(pipeline, name, larger[f].at(name), bytes), 0.004) << name << " of frame " << f;
            else
                EXPECT_TRUE(larger[f].at(name) == bytes) << name << " of frame " << f;
    EXPECT_NE(expected[0], expected[2]) << "nothing changes: the test shows nothing";
}

// All but denoise.json, which is one_ray.json without its tracer.
INSTANTIATE_TEST_SUITE_P(Shipped, SizeGpu,
                         ::testing::Values("cascades_only", "covered", "fidelityfx", "hybrid_cascades",
                                           "hybrid_fidelityfx", "hybrid_shadows", "hybrid_shadows_best",
                                           "hybrid_shadows_fast", "many_rays", "one_ray", "raw", "reference",
                                           "shadows", "shadows_best", "shadows_fast"),
                         [](const auto& name) { return std::string(name.param); });

class SizeChangeGpu : public GpuTest {};

// What the host brings lies in larger images, beside garbage.
TEST_F(SizeChangeGpu, WhatLiesBesideTheFrameIsNotRead) {
    for (const char* name : {"shadows", "hybrid_shadows"}) {
        const CheckedPipeline pipeline = shadow_pipeline_file(name);
        const Recording recording = record(pipeline, plaza_shot(size, 3), 3, recorded_facts());
        SizedRun run(pipeline, largest, recording.plan.facts);
        for (size_t f = 0; f < 3; ++f) {
            run.frame(recording.frames[f], f ? &recording.frames[f - 1] : nullptr);
            for (const auto& [output, bytes] : recording.frames[f].outputs)
                if (f > 0 && output == "color")
                    EXPECT_LT(largest_difference(pipeline, output, run.output(output), bytes), 0.004) << name;
                else
                    EXPECT_TRUE(run.output(output) == bytes) << name << ": " << output << " of frame " << f;
        }
    }
}

std::vector<double> visibility_of(const Bytes& bytes) {
    std::vector<double> values(bytes.size() / 2);
    for (size_t i = 0; i < values.size(); ++i) {
        uint16_t half = 0;
        std::memcpy(&half, &bytes[2 * i], 2);
        values[i] = glm::unpackHalf1x16(half);
    }
    return values;
}

// Rays per pixel that would be as far from the truth.
double n_eff(const Bytes& bytes, const Truth& truth) {
    const std::vector<double> values = visibility_of(bytes);
    double signal = 0, error = 0;
    for (size_t i = 0; i < values.size(); ++i) {
        if (truth.receiver[i] <= 0) continue;
        const double v = truth.visibility[i], d = values[i] - v;
        if (v >= 1.0 / 256 && v <= 255.0 / 256) signal += v * (1 - v);
        error += d * d;
    }
    return signal / error;
}

Shot shipped_shot(const char* name, std::array<uint32_t, 2> of_size, bool still) {
    Diagnostics diagnostics;
    auto shot = read_shot(std::filesystem::path(PENUMBRA_SOURCE_DIR) / "scenes" / (std::string(name) + ".shot.json"),
                          diagnostics);
    if (!shot) throw std::runtime_error(diagnostics.text());
    shot->size = of_size;
    if (still) shot->camera.resize(1);
    return std::move(*shot);
}

struct Change {
    const char* shot;
    bool still;
    std::array<uint32_t, 2> before, after;
};

class HistoryGpu : public GpuTest, public ::testing::WithParamInterface<Change> {};

// N_eff of the frame at which the size changes, beside that of the same frame without a past and with one of its own
// size; and four frames on.
TEST_P(HistoryGpu, SurvivesAChangeOfSize) {
    constexpr uint32_t change = 16, frames = change + 5;
    const auto& [name, still, before, after] = GetParam();
    const CheckedPipeline pipeline = shadow_pipeline_file("shadows");
    const Facts facts = still ? Facts{{"alpha", false}, {"moves", false}, {"sun_moves", false}} : recorded_facts();
    const Recording old = record(pipeline, shipped_shot(name, before, still), change, facts, false),
                    own = record(pipeline, shipped_shot(name, after, still), frames, facts, false);
    const Extent most{std::max(before[0], after[0]), std::max(before[1], after[1])};
    SizedRun changed(pipeline, most, own.plan.facts), anew(pipeline, most, own.plan.facts);
    for (uint32_t f = 0; f < change; ++f) changed.frame(old.frames[f], f ? &old.frames[f - 1] : nullptr);
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto truths = open_truth(gpu(), shipped_shot(name, after, still), diagnostics, warnings);
    ASSERT_TRUE(truths) << diagnostics.text();
    for (uint32_t f = change; f < frames; ++f) {
        changed.frame(own.frames[f], f == change ? &old.frames[f - 1] : &own.frames[f - 1]);
        anew.frame(own.frames[f], f == change ? nullptr : &own.frames[f - 1]);
        EXPECT_EQ(changed.view().reset().reason, Reset::Reason::none);
        if (f != change && f + 1 != frames) continue;
        const Truth truth = counted_truth(*truths, f, 144);
        const double kept = n_eff(changed.output("visibility"), truth),
                     reset = n_eff(anew.output("visibility"), truth),
                     ideal = n_eff(own.frames[f].outputs.at("visibility"), truth);
        std::printf("%s%s, %ux%u to %ux%u, frame %+d: N_eff %.2f; without a past %.2f, with one of its own size %.2f\n", name,
                    still ? " (still)" : "", before[0], before[1], after[0], after[1], int(f) - int(change), kept,
                    reset, ideal);
        EXPECT_GT(kept, reset);
        EXPECT_GT(kept, 0.5 * ideal);
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
