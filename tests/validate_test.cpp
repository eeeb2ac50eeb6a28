// SPDX-License-Identifier: MIT
// The node `validate` counts exactly what is bad, whatever kind, format, size, level or layer; a pipeline
// that validates itself runs what it ran before and gives the same bits; and the shipped pipelines are clean
// on the shots, over memory that is full of NaN.
#include "app/validate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "app/session.h"
#include "app/validation.h"
#include "host/device/gpu.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_pipeline.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

using Counts = std::array<uint64_t, 4>;  // checked, NaN, infinite, out of range

CheckedPipeline validating(const CheckedPipeline& pipeline) {
    Diagnostics diagnostics;
    auto result = with_validation(pipeline, test_nodes(), diagnostics);
    if (!result) throw std::runtime_error(diagnostics.text());
    return std::move(*result);
}

Target target_of(Extent extent, bool cpu) {
    Target target;
    target.extent = extent;
    target.device = device_table(handles_of(gpu()));
    target.device.cpu = cpu;
    return target;
}

std::unique_ptr<View> open_view(const CheckedPipeline& pipeline, const Target& target) {
    CompileOptions options;
    options.poison = true;
    Diagnostics diagnostics;
    auto plan = compile(pipeline, target, options, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::make_unique<View>(
        std::make_shared<Program>(handles_of(gpu()), std::make_shared<Plan>(std::move(*plan))),
        ViewOptions{1, 0});
}

// One frame; what each pass that validates has counted, by its node.
std::map<std::string, Counts> counts_of(View& view, std::span<const SlotBinding> slots = {}) {
    const Extent extent = view.plan().extent;
    const Camera camera = camera_at({0, 0, 0}, 0, extent);
    gpu().run([&](VkCommandBuffer cmd) {
        view.record(cmd, frame_between(camera, camera, extent, 0, true), slots);
    });
    std::map<std::string, Counts> counts;
    for (const ValidatePass& pass : validate_passes(view.plan())) {
        const std::string& node = view.plan().passes[pass.pass].node;
        const auto c = counters_of(view, node);
        counts[node] = {c.at("checked"), c.at("nan"), c.at("inf"), c.at("out_of_range")};
    }
    return counts;
}

// --- Exact counts ------------------------------------------------------------------------------------------

// What tests/nodes/spoil.comp stores, by its own rule, as the format can hold it.
Counts expected_counts(Format format, uint64_t texels, uint32_t first_nan, float least, float greatest) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const std::array<std::array<float, 4>, 8> kinds = {{{nan, .5f, .5f, .5f},
                                                        {.5f, inf, .5f, .5f},
                                                        {-inf, .5f, .5f, .5f},
                                                        {inf, nan, .5f, .5f},
                                                        {-1, .5f, .5f, .5f},
                                                        {.5f, 2, .5f, .5f},
                                                        {0, 0, 0, 0},
                                                        {1, 1, 1, 1}}};
    Counts counts{texels, 0, 0, 0};
    for (uint64_t i = 0; i < texels; ++i) {
        const uint64_t kind = (i + 16 - first_nan) % 16;
        bool is_nan = false, is_inf = false, is_outside = false;
        for (uint32_t c = 0; kind < kinds.size() && c < info(format).channels; ++c) {
            float v = kinds[kind][c];
            if (format == Format::r11g11b10f && v < 0) v = 0;  // it has no sign
            is_nan |= std::isnan(v);
            is_inf |= std::isinf(v);
            is_outside |= v < least || v > greatest;
        }
        counts[1] += is_nan;
        counts[2] += !is_nan && is_inf;
        counts[3] += !is_nan && !is_inf && is_outside;
    }
    return counts;
}

class Validate : public GpuTest {};

TEST_F(Validate, CountsBadTexelsOfEveryFloatFormatAtAnySize) {
    for (const Format format : {Format::r32f, Format::rg32f, Format::rgba32f, Format::r16f, Format::rg16f,
                                Format::rgba16f, Format::r11g11b10f}) {
        const CheckedPipeline pipeline = validating(
            shadow_pipeline(std::string(R"({ "penumbra": 1, "name": "spoiled", "outputs": ["spoiled"],
                "nodes": { "spoil": { "type": "spoil" } }, "resources": { "spoiled": { "format": ")") +
                            info(format).name + "\" } } }"));
        for (const Extent frame : {Extent{1, 1}, {33, 19}, {128, 384}, {131, 6}, {2, 3 * 523}})
            for (const bool cpu : {true, false}) {
                const auto view = open_view(pipeline, target_of(frame, cpu));
                const uint64_t texels = uint64_t{(frame.width + 1) / 2} * ((frame.height + 2) / 3);
                for (const uint32_t first_nan : {0u, 5u, 15u}) {
                    ASSERT_TRUE(view->set_param("spoil", "nan", first_nan));
                    EXPECT_EQ(counts_of(*view).at("spoiled@validate"),
                              expected_counts(format, texels, first_nan, 0, 1))
                        << info(format).name << " " << frame.width << "x" << frame.height << " from "
                        << first_nan;
                }
            }
    }
}

// A node of the pipeline's own beside the added one: each has its own range, whose ends belong to it.
TEST_F(Validate, APipelinesOwnNodeHasItsOwnRange) {
    const CheckedPipeline own = shadow_pipeline(R"({ "penumbra": 1, "name": "own", "outputs": ["spoiled"],
        "nodes": { "spoil": { "type": "spoil" },
                   "look": { "type": "validate", "in": { "image": "spoiled" },
                             "params": { "least": [-1, 0, 0, 1], "greatest": [1.5, 0, 0, 1] } } } })");
    const auto alone = open_view(own, target_of({64, 48}, true));
    const Counts expected = expected_counts(Format::r32f, 32 * 16, 0, -1, 1.5f);
    EXPECT_EQ(expected[3], 0u);
    EXPECT_EQ(counts_of(*alone), (std::map<std::string, Counts>{{"look", expected}}));
    const auto both = open_view(validating(own), target_of({64, 48}, true));
    EXPECT_EQ(counts_of(*both), (std::map<std::string, Counts>{
                                    {"look", expected},
                                    {"spoiled@validate", expected_counts(Format::r32f, 32 * 16, 0, 0, 1)}}));

    std::vector<Finding> findings = no_findings(both->plan());
    add_frame(findings, 7, both->statistics());
    const auto json = findings_json(both->plan(), findings);
    EXPECT_EQ(json["spoiled"]["out_of_range"], 32 * 16 / 16) << "-1; the 2 is in a channel that r32f lacks";
    EXPECT_EQ(json["spoiled"]["first_frame"], 7);
    EXPECT_EQ(json["look"]["out_of_range"], 0);
    const std::string text = complaint(findings);
    EXPECT_NE(
        text.find("nodes.spoil.out.spoiled: frame 7: of 512 texels 32 NaN, 64 infinite, 32 out of range"),
        std::string::npos)
        << text;
}

TEST_F(Validate, LevelsLayersAndBuffersAreLookedAtWhole) {
    const CheckedPipeline pipeline = validating(shadow_pipeline(R"({ "penumbra": 1, "name": "more",
        "inputs": { "slices": { "extent": "any" } },
        "outputs": ["chain", "sliced", "numbers", "points", "row", "words", "partial"],
        "nodes": { "spoil": { "type": "spoil_more" } } })"));
    const uint32_t layers = 3;
    for (const Extent frame : {Extent{37, 23}, {64, 64}, {5, 91}}) {
        SCOPED_TRACE(testing::Message() << frame.width << "x" << frame.height);
        Target target = target_of(frame, true);
        target.inputs["slices"] = {Format::r32f, {11, 7}, layers};
        const auto view = open_view(pipeline, target);
        const GpuImage slices = make_layered_image(gpu(), VK_FORMAT_R32_SFLOAT, {11, 7}, layers,
                                                   VK_IMAGE_USAGE_SAMPLED_BIT, "slices");
        gpu().run([&](VkCommandBuffer cmd) {  // its texels are never read but by the watcher
            VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
            barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
            barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT;
            barrier.newLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
            barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
            barrier.image = slices.get();
            barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, layers};
            VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
            dependency.imageMemoryBarrierCount = 1;
            dependency.pImageMemoryBarriers = &barrier;
            vkCmdPipelineBarrier2(cmd, &dependency);
        });
        SlotBinding binding;
        binding.image = slices.view.get();
        auto counts = counts_of(*view, std::span(&binding, 1));

        uint64_t chain = 0;
        const auto levels = static_cast<uint64_t>(std::bit_width(std::max(frame.width, frame.height)));
        for (uint64_t l = 0; l < levels; ++l)
            chain += uint64_t{std::max(frame.width >> l, 1u)} * std::max(frame.height >> l, 1u);
        EXPECT_EQ(counts["chain@validate"], (Counts{chain, levels, levels - 1, 0}));
        EXPECT_EQ(counts["sliced@validate"], (Counts{11 * 7 * layers, layers, 0, 0}));
        EXPECT_EQ(counts["slices@validate"][0], 11 * 7 * layers);
        EXPECT_EQ(counts["numbers@validate"], (Counts{5003, 1, 1, 1}));
        EXPECT_EQ(counts["points@validate"], (Counts{77, 1, 0, 1}));
        EXPECT_EQ(counts["row@validate"],
                  (Counts{uint64_t{frame.width} * ((frame.height + 6) / 7), 0, 1, 1}));
        EXPECT_EQ(counts.size(), 6u) << "words and what is written in part are not looked at";
        const auto json = findings_json(view->plan(), no_findings(view->plan()));
        EXPECT_TRUE(json["words"].is_null());
        EXPECT_TRUE(json["partial"].is_null());
        EXPECT_TRUE(json["chain"].is_object());
    }
}

// --- Watching changes nothing ------------------------------------------------------------------------------

class ValidatePlan : public ::testing::TestWithParam<std::string> {};

// Under every combination of the facts that pipelines ask for.
TEST_P(ValidatePlan, RunsTheSameNodesInTheSameOrderOnTheSameResources) {
    const CheckedPipeline plain = shipped_pipeline(GetParam()), watched = validating(plain);
    const char* names[] = {"sun_up", "sun_disc", "casters", "moves"};
    for (uint32_t bits = 0; bits < 16; ++bits) {
        Target target;
        target.extent = {333, 77};
        target.inputs = told_inputs(plain);
        target.device = reference_device();
        for (uint32_t i = 0; i < 4; ++i) target.facts[names[i]] = (bits >> i & 1) != 0;
        Diagnostics diagnostics;
        const auto a = compile(plain, target, {}, diagnostics);
        const auto b = compile(watched, target, {}, diagnostics);
        ASSERT_TRUE(a && b) << diagnostics.text();
        const auto passes = [](const Plan& plan) {
            std::vector<std::string> lines;
            for (const PlanPass& pass : plan.passes) {
                if (pass.type == "validate") continue;
                std::string& line = lines.emplace_back(pass.node + " " + pass.variant);
                for (const auto& list : {pass.reads, pass.writes})
                    for (const std::string& name : list) line += " " + name;
            }
            return lines;
        };
        EXPECT_EQ(passes(*a), passes(*b)) << bits;
        const auto described = [](const Plan& plan) {
            std::set<std::string> lines;
            for (const PlanResource& r : plan.resources)
                lines.insert(r.names.back() + (r.history ? " history " : " ") + info(r.format).name);
            for (const HostSlot& slot : plan.slots) lines.insert("slot " + slot.name);
            for (const Culled& culled : plan.culled) lines.insert("culled " + culled.node + culled.cond);
            return lines;
        };
        EXPECT_EQ(described(*a), described(*b)) << bits;
        // Every image that a node writes is looked at, in the pass behind its writer or soon after.
        std::set<std::string> looked_at;
        for (const ValidatePass& pass : validate_passes(*b)) {
            looked_at.insert(pass.resource);
            EXPECT_TRUE(pass.origin.starts_with("nodes.") || pass.origin.starts_with("inputs."))
                << pass.origin;
        }
        for (const PlanResource& r : b->resources)
            // Of gather's frame_worth, what is not written is not read.
            if (r.kind == PortKind::image && info(r.format).kind != FormatClass::uint &&
                !r.names.back().starts_with("frame_worth")) {
                EXPECT_TRUE(looked_at.contains(r.names.back())) << r.names.back();
            }
    }
}

INSTANTIATE_TEST_SUITE_P(Pipelines, ValidatePlan, ::testing::ValuesIn(pipeline_files()),
                         [](const auto& test) { return test.param; });

// A node that watches follows what it reads: it runs no producer, makes no optional output exist, and asks
// the host for nothing.
TEST(ValidateNode, KeepsNothingAlive) {
    const CheckedPipeline pipeline =
        shadow_pipeline(R"({ "penumbra": 1, "name": "idle", "outputs": ["view_depth"],
        "inputs": { "depth": {}, "albedo": {} },
        "nodes": { "guides": { "type": "guides" }, "clear": { "type": "clear", "if": "moves" },
                   "a": { "type": "validate", "in": { "image": "cleared" }, "if": "moves" },
                   "b": { "type": "validate", "in": { "image": "albedo" } },
                   "c": { "type": "validate", "in": { "image": "view_depth" } } } })");
    Target target;
    target.extent = {8, 8};
    target.device = reference_device();
    Diagnostics diagnostics;
    const auto plan = compile(pipeline, target, {}, diagnostics);
    ASSERT_TRUE(plan) << diagnostics.text();
    std::vector<std::string> ran, culled;
    for (const PlanPass& pass : plan->passes) ran.push_back(pass.node);
    for (const Culled& c : plan->culled) culled.push_back(c.node + " " + c.why);
    EXPECT_EQ(ran, (std::vector<std::string>{"guides", "c"}));
    EXPECT_EQ(culled, (std::vector<std::string>{"clear unused", "a unused", "b unused"}));
    EXPECT_EQ(plan->slots.size(), 1u);
}

TEST(ValidateNode, WrongUseIsExplained) {
    const auto errors = [](const std::string& look) {
        Diagnostics diagnostics;
        const auto pipeline = parse_pipeline(R"({ "penumbra": 1, "name": "bad", "outputs": ["receiver_words"],
            "inputs": { "depth": {}, "sun": {} }, "nodes": { "guides": { "type": "guides" },
            "classify": { "type": "classify" }, "look": )" +
                                                 look + "} }",
                                             "bad.json", {}, diagnostics);
        if (pipeline) check(*pipeline, test_nodes(), diagnostics);
        return diagnostics.text();
    };
    EXPECT_EQ(errors(R"({ "type": "validate", "in": { "image": "view_depth" } })"), "");
    EXPECT_NE(errors(R"({ "type": "validate", "in": { "image": "receiver_words" } })")
                  .find("the port takes an image"),
              std::string::npos);
    EXPECT_NE(
        errors(
            R"({ "type": "validate", "params": { "of": "floats" }, "in": { "floats": "receiver_words" } })")
            .find("has elements u32"),
        std::string::npos);
    EXPECT_NE(errors(R"({ "type": "validate" })").find("no resource named \"image\""), std::string::npos);
    EXPECT_NE(
        errors(R"({ "type": "validate", "params": { "of": "picture" }, "in": { "image": "view_depth" } })")
            .find("no value \"picture\""),
        std::string::npos);

    const CheckedPipeline pipeline = shipped_pipeline("raw");
    NodeSet without;
    Diagnostics diagnostics;
    EXPECT_FALSE(with_validation(pipeline, without, diagnostics));
    EXPECT_NE(diagnostics.text().find("validation needs a node type \"validate\""), std::string::npos);
}

// --- Shipped pipelines are clean ---------------------------------------------------------------------------

struct Frames {
    std::vector<std::vector<std::byte>> images;  // every output of every frame
    std::vector<Finding> findings;
    uint64_t looked_at = 0;  // texels
};

Frames run(const std::string& pipeline, const Shot& shot, uint32_t frames, bool validate,
           std::optional<uint32_t> poison) {
    const CheckedPipeline checked_pipeline = pipeline_for(shot, pipeline);
    SessionOptions options;
    options.size = shot.size;
    options.cascade_size = 64;
    options.captures = checked_pipeline.output_names();
    options.validate = validate;
    options.poison = poison;
    const auto session = open_session(checked_pipeline, shot, options, test_nodes());
    Frames result;
    result.findings = no_findings(session->plan());
    for (uint32_t frame = 0; frame < frames; ++frame) {
        // The reset in the middle lets garbage history in, if anything does.
        const FrameCost cost = session->run_frame(frame, frame == 0 || frame == 5);
        add_frame(result.findings, frame, cost.passes);
        for (const std::string& name : checked_pipeline.output_names()) {
            const auto bytes = session->view().captured(name);
            result.images.emplace_back(bytes.begin(), bytes.end());
        }
    }
    for (const Finding& finding : result.findings) {
        const std::vector<PlanBinding>& bindings = session->plan().passes[finding.pass.pass].bindings;
        const PlanBinding& read = *std::ranges::find_if(bindings, [](const PlanBinding& b) {
            return !b.port.empty() && b.source != BindingSource::nothing;
        });
        uint64_t texels = 0;
        if (read.source == BindingSource::host) {
            const HostSlot& slot = session->plan().slots[read.index];
            texels = uint64_t{slot.extent.width} * slot.extent.height * slot.layers;
        } else {
            const PlanResource& r = session->plan().resources[read.index];
            for (uint32_t l = 0; r.kind == PortKind::image && l < r.levels; ++l)
                texels += uint64_t{std::max(r.extent.width >> l, 1u)} * std::max(r.extent.height >> l, 1u) *
                          r.layers;
            if (r.kind != PortKind::image) texels = r.count;
        }
        EXPECT_EQ(finding.all.checked, frames * texels) << finding.pass.origin;
        result.looked_at += finding.all.checked;
    }
    return result;
}

// reference.json is for the command of that name.
std::vector<std::string> rendered_names() {
    std::vector<std::string> names = rendering_pipeline_files();
    std::erase(names, "reference");
    return names;
}

class ValidatedPipeline : public GpuTest, public ::testing::WithParamInterface<std::string> {};

TEST_P(ValidatedPipeline, IsCleanAndGivesTheSameBits) {
    const Shot shot = plaza_shot({75, 43}, 8);
    const Frames plain = run(GetParam(), shot, 8, false, std::nullopt);
    EXPECT_EQ(plain.findings.size(), 0u);
    for (const uint32_t poison : {0u, 1u}) {
        const Frames validated = run(GetParam(), shot, 8, true, poison);
        EXPECT_EQ(complaint(validated.findings), "");
        EXPECT_GT(validated.looked_at, 8 * 75 * 43 * 3u);
        EXPECT_TRUE(validated.images == plain.images) << "poison " << poison;
    }
}

INSTANTIATE_TEST_SUITE_P(Shipped, ValidatedPipeline, ::testing::ValuesIn(rendered_names()),
                         [](const auto& test) { return test.param; });

class ValidatedShots : public ValidatedPipeline {};

TEST_P(ValidatedShots, AreClean) {
    for (const char* name : {"cards", "colonnade", "lamp"}) {
        Shot shot = shot_named(name);
        shot.size = {96, 53};
        EXPECT_EQ(complaint(run(GetParam(), shot, 4, true, 0).findings), "") << name;
    }
}

// Between them they have our denoisers, our classifiers and the published denoiser.
INSTANTIATE_TEST_SUITE_P(Shipped, ValidatedShots,
                         ::testing::Values("cascades_only", "fidelityfx", "covered", "hybrid_cascades",
                                           "hybrid_fidelityfx", "hybrid_shadows", "sigma"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace penumbra::test
