// SPDX-License-Identifier: MIT
// What compile() decides, on node sets made for each question and without a device: who runs, what exists, in
// which format and size, with which constants, and what is refused.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <set>

#include "graph/interface.h"
#include "penumbra/graph.h"
#include "tests/plan_checks.h"
#include "tests/toy_nodes.h"

namespace penumbra::test {
namespace {

// A source, a filter with history, an in-place update and an optional extra output.
NodeSet small_set() {
    NodeSet set;
    const auto add = [&](const char* name, const std::string& text) {
        set.add({.type = parse_toy(text, name)});
    };
    add("source", R"({ "node": "source", "doc": "d", "shader": "s.comp",
      "outputs": { "value": { "kind": "image", "format": "r16f" },
                   "extra": { "kind": "image", "format": "rgba16f", "optional": true } },
      "params": { "taps": { "type": "int", "default": 4, "constant": true, "doc": "d" },
                  "gain": { "type": "float", "default": 2, "range": [0, 8], "doc": "d" },
                  "axis": { "type": "vec3", "default": [1, 2, 3], "doc": "d" },
                  "on": { "type": "bool", "default": true, "doc": "d" },
                  "shape": { "type": "enum", "values": ["box", "tent"], "default": "tent", "doc": "d" } },
      "dispatch": { "over": "frame", "group": [8, 8] },
      "classes": { "cpu": { "group": [64, 1], "per_thread": [1, 2], "taps": 9 } } })");
    add("mix", R"({ "node": "mix", "doc": "d", "shader": "s.comp",
      "inputs": { "value": { "kind": "image", "format": "r16f" },
                  "before": { "kind": "image", "format": ["r16f", "r32f"], "as": "storage", "previous": true, "optional": true },
                  "mask": { "kind": "image", "format": "r8", "optional": true } },
      "outputs": { "mixed": { "kind": "image", "format": ["r16f", "r8"] } },
      "dispatch": { "over": "value" } })");
    add("twice", R"({ "node": "twice", "doc": "d", "shader": "s.comp",
      "inputs": { "value": { "kind": "image", "format": "r16f", "as": "storage" } },
      "outputs": { "doubled": { "kind": "image", "updates": "value" } },
      "dispatch": { "over": "value" } })");
    add("motion_reader", R"({ "node": "motion_reader", "doc": "d", "shader": "s.comp",
      "inputs": { "motion": { "kind": "image", "format": ["rg16f", "rgba16f", "r16f", "rg8"] },
                  "motion_prev": { "kind": "image", "format": ["rg16f", "rgba16f", "r32f"], "previous": true } },
      "outputs": { "seen": { "kind": "image", "format": "r16f", "extent": "motion" } },
      "dispatch": { "over": "seen" } })");
    add("tally", R"({ "node": "tally", "doc": "d", "shader": "s.comp",
      "outputs": { "kept": { "kind": "image", "format": "r16f", "writes": "kept" } },
      "dispatch": { "over": "kept" } })");
    add("picky", R"({ "node": "picky", "doc": "d", "shader": "s.comp",
      "inputs": { "motion": { "kind": "image", "format": ["rgba16f", "rg16f"] } },
      "outputs": { "picked": { "kind": "image", "format": "r16f" } }, "dispatch": { "over": "frame" } })");
    return set;
}

Target target_of(Extent extent, bool cpu = false) {
    Target target;
    target.extent = extent;
    target.device = reference_device(cpu);
    return target;
}

struct Result {
    std::optional<Plan> plan;
    std::string errors;
};

Result compile_text(const NodeSet& set, const std::string& body, const Target& target,
                    const CompileOptions& options = {}) {
    Diagnostics diagnostics;
    const std::string text = R"({ "penumbra": 1, "name": "p", )" + body + "}";
    const auto pipeline = parse_pipeline(text, "p.json", {}, diagnostics);
    const auto checked = pipeline ? check(*pipeline, set, diagnostics) : std::nullopt;
    if (!checked) throw std::runtime_error(diagnostics.text());
    Result result;
    result.plan = compile(*checked, target, options, diagnostics);
    result.errors = diagnostics.text();
    return result;
}

const PlanPass& pass_of(const Plan& plan, const std::string& node) {
    for (const PlanPass& pass : plan.passes)
        if (pass.node == node) return pass;
    throw std::runtime_error("no pass " + node);
}

const PlanResource* resource_of(const Plan& plan, const std::string& name) {
    for (const PlanResource& r : plan.resources)
        if (std::find(r.names.begin(), r.names.end(), name) != r.names.end()) return &r;
    return nullptr;
}

// Whether anything is behind a port's binding.
bool is_bound(const PlanPass& pass, const std::string& port) {
    const PlanBinding* binding = pass.binding(port);
    return binding && binding->source != BindingSource::nothing;
}

size_t position(const Plan& plan, const std::string& node) {
    return static_cast<size_t>(&pass_of(plan, node) - plan.passes.data());
}

void expect_sound(const Plan& plan) {
    EXPECT_EQ(overlap_errors(plan), std::vector<std::string>{});
    EXPECT_EQ(hazard_errors(plan), std::vector<std::string>{});
}

TEST(CompileOutputs, AnOptionalOutputExistsOnlyWhereItIsAskedFor) {
    const NodeSet set = small_set();
    const std::string nodes = R"("nodes": { "source": { "type": "source", "out": { "extra": "more" } } })";
    const Result without = compile_text(set, R"("outputs": ["value"], )" + nodes, target_of({64, 64}));
    EXPECT_FALSE(resource_of(*without.plan, "more"));
    EXPECT_EQ(pass_of(*without.plan, "source").variant, "extra=0");
    const Result with = compile_text(set, R"("outputs": ["value", "more"], )" + nodes, target_of({64, 64}));
    EXPECT_TRUE(resource_of(*with.plan, "more"));
    EXPECT_EQ(pass_of(*with.plan, "source").variant, "extra=1");
    CompileOptions options;
    options.captures = {"more"};
    const Result captured =
        compile_text(set, R"("outputs": ["value"], )" + nodes, target_of({64, 64}), options);
    EXPECT_TRUE(resource_of(*captured.plan, "more"));
}

TEST(CompileVariants, AnAbsentPortWithAChoiceOfFormatsStillNamesACompiledVariant) {
    NodeSet set = small_set();
    NodeEntry mix = *set.find("mix");
    for (const Variant& variant : all_variants(mix.type)) mix.shaders[to_string(variant)] = {0};
    set.add(mix);
    const Result result = compile_text(set, R"("outputs": ["mixed"], "nodes": {
        "source": { "type": "source" }, "mix": { "type": "mix" } })",
                                       target_of({64, 64}));
    ASSERT_TRUE(result.plan) << result.errors;
    EXPECT_FALSE(is_bound(pass_of(*result.plan, "mix"), "before"));
}

TEST(CompileVariants, TheWritersFormatChoosesTheReadersVariant) {
    const NodeSet set = small_set();
    const Result result =
        compile_text(set, R"("outputs": ["mixed"], "nodes": { "source": { "type": "source" },
        "mix": { "type": "mix", "in": { "before": "mixed@-1" } } })",
                     target_of({64, 64}));
    EXPECT_EQ(pass_of(*result.plan, "mix").variant, "before=r16f,mixed=r16f");
    EXPECT_TRUE(is_bound(pass_of(*result.plan, "mix"), "before"));
    EXPECT_FALSE(is_bound(pass_of(*result.plan, "mix"), "mask"));
}

TEST(CompileClasses, TheDeviceClassOverridesWhatThePipelineDoesNotSet) {
    const NodeSet set = small_set();
    const std::string body = R"("outputs": ["value"], "nodes": { "source": { "type": "source" } })";
    const Plan gpu = *compile_text(set, body, target_of({640, 480})).plan;
    const Plan cpu = *compile_text(set, body, target_of({640, 480}, true)).plan;
    // Workgroup, pixels per thread, counter base, ON_CPU, taps.
    EXPECT_EQ(gpu.passes[0].constants, (std::vector<uint32_t>{8, 8, 1, 1, 1, 0, 0, 4}));
    EXPECT_EQ(cpu.passes[0].constants, (std::vector<uint32_t>{64, 1, 1, 1, 2, 0, 1, 9}));
    EXPECT_EQ(gpu.passes[0].groups, (std::array<uint32_t, 3>{80, 60, 1}));
    EXPECT_EQ(cpu.passes[0].groups, (std::array<uint32_t, 3>{10, 240, 1}));
    const Plan set_by_user = *compile_text(set, R"("outputs": ["value"], "nodes": {
        "source": { "type": "source", "params": { "taps": 2 } } })",
                                           target_of({640, 480}, true))
                                  .plan;
    EXPECT_EQ(set_by_user.passes[0].constants.back(), 2u);
}

TEST(CompileConstants, PushConstantsFollowStd430) {
    const NodeSet set = small_set();
    const Plan plan =
        *compile_text(set, R"("outputs": ["value"], "nodes": { "source": { "type": "source" } })",
                      target_of({64, 64}))
             .plan;
    const PushConstants layout = push_constants(set.find("source")->type);
    const std::vector<std::optional<uint32_t>> offsets = {std::nullopt, 0, 16, 28,
                                                          32};  // taps gain axis on shape
    EXPECT_EQ(layout.offsets, offsets);
    ASSERT_EQ(plan.passes[0].push.size(), 36u);
    std::array<float, 7> floats;
    std::memcpy(floats.data(), plan.passes[0].push.data(), sizeof floats);
    EXPECT_EQ(floats[0], 2);
    EXPECT_EQ((std::array{floats[4], floats[5], floats[6]}), (std::array{1.0f, 2.0f, 3.0f}));
    std::array<uint32_t, 2> words;
    std::memcpy(words.data(), plan.passes[0].push.data() + 28, sizeof words);
    EXPECT_EQ(words, (std::array<uint32_t, 2>{1, 1}));  // true, "tent"
}

TEST(CompileConstants, AValueFitsItsParameterOnly) {
    const NodeSet set = small_set();
    const NodeType& type = set.find("source")->type;
    EXPECT_TRUE(fits(*type.param("gain"), ParamValue(8.0f)));
    EXPECT_FALSE(fits(*type.param("gain"), ParamValue(8.5f)));
    EXPECT_FALSE(fits(*type.param("gain"), ParamValue(std::numeric_limits<float>::quiet_NaN())));
    EXPECT_FALSE(fits(*type.param("gain"), ParamValue(int32_t{1})));
    EXPECT_TRUE(fits(*type.param("axis"), ParamValue(std::vector<float>{0, 0, 1})));
    EXPECT_FALSE(fits(*type.param("axis"), ParamValue(std::vector<float>(64, 1.0f))))
        << "would overrun the block";
    EXPECT_TRUE(fits(*type.param("shape"), ParamValue(std::string("box"))));
    EXPECT_FALSE(fits(*type.param("shape"), ParamValue(std::string("cone"))));
}

// One memory that lives all the time, so that nobody else gets it; no previous value, and no other name.
TEST(CompileKept, HasOneMemoryForAllFrames) {
    const NodeSet set = small_set();
    const std::string nodes = R"("t": { "type": "tally" }, "source": { "type": "source" },
          "a": { "type": "twice", "in": { "value": "value" }, "out": { "doubled": "two" } })";
    const Plan plan =
        *compile_text(set, R"("outputs": ["kept", "two"], "nodes": {)" + nodes + "}", target_of({64, 64}))
             .plan;
    const PlanResource& kept = *resource_of(plan, "kept");
    EXPECT_TRUE(kept.kept);
    EXPECT_TRUE(kept.clear_on_reset);
    EXPECT_EQ(kept.length, plan.period());
    EXPECT_EQ(kept.offset[0], kept.offset[1]);
    expect_sound(plan);
    for (const auto& [reader, message] : std::vector<std::pair<std::string, std::string>>{
             {R"("r": { "type": "mix", "in": { "value": "two", "before": "kept@-1" } })",
              "\"kept\" is kept in place, so its previous value is gone"},
             {R"("r": { "type": "twice", "in": { "value": "kept" }, "out": { "doubled": "mixed" } })",
              "\"kept\" is kept for the next frame and cannot be updated"}}) {
        std::string errors;
        try {
            (void)compile_text(set,
                               R"("outputs": ["kept", "mixed"], "nodes": {)" + nodes + ", " + reader + "}",
                               target_of({64, 64}));
        } catch (const std::runtime_error& error) {
            errors = error.what();
        }
        EXPECT_NE(errors.find(message), std::string::npos) << errors;
    }
}

TEST(CompileResets, WhatBeginsAsZeroIsClearedByAReset) {
    const NodeSet set = small_set();
    const std::string body = R"("outputs": ["mixed"], "nodes": { "source": { "type": "source" },
        "mix": { "type": "mix", "in": { "before": "mixed@-1" } } })";
    for (const bool zero : {false, true}) {
        const Plan plan =
            *compile_text(set, (zero ? R"("resources": { "mixed": { "first": "clear" } }, )" : "") + body,
                          target_of({64, 64}))
                 .plan;
        EXPECT_EQ(resource_of(plan, "mixed")->clear_on_reset, zero);
        ASSERT_EQ(plan.reset.size(), 1u);
        EXPECT_EQ(plan.reset[0].clear, zero);
    }
}

TEST(CompileUpdates, AChainIsOneResourceThatLivesFromFirstToLastName) {
    const NodeSet set = small_set();
    const Plan plan =
        *compile_text(set, R"("outputs": ["late", "four"], "resources": { "four": { "first": "clear" } },
        "nodes": { "source": { "type": "source" },
          "a": { "type": "twice", "out": { "doubled": "two" } },
          "b": { "type": "twice", "in": { "value": "two" }, "out": { "doubled": "four" } },
          "mix": { "type": "mix", "in": { "value": "two", "before": "four@-1" }, "out": { "mixed": "late" } } })",
                      target_of({64, 64}))
             .plan;
    const PlanResource& chain = *resource_of(plan, "four");
    EXPECT_EQ(chain.names, (std::vector<std::string>{"value", "two", "four"}));
    EXPECT_EQ(&chain, resource_of(plan, "value"));
    EXPECT_LT(position(plan, "mix"), position(plan, "b")) << "readers of an old name come before its updater";
    EXPECT_EQ(chain.first_pass, 0u);
    EXPECT_EQ(chain.length, plan.passes.size() + position(plan, "mix") + 1);
    EXPECT_TRUE(chain.history);
    EXPECT_TRUE(chain.clear_on_reset) << "the last name's \"first\" is the chain's";
    EXPECT_TRUE(chain.image_usage & VK_IMAGE_USAGE_TRANSFER_DST_BIT);
    expect_sound(plan);
}

TEST(CompileUpdates, ACaptureOfAnOldNameComesBeforeItsUpdater) {
    const NodeSet set = small_set();
    CompileOptions options;
    options.captures = {"value"};
    const Plan plan = *compile_text(set, R"("outputs": ["doubled"], "nodes": {
        "source": { "type": "source" }, "a": { "type": "twice" } })",
                                    target_of({64, 64}), options)
                           .plan;
    EXPECT_EQ(plan.passes[1].kind, PassKind::capture);
    EXPECT_EQ(plan.passes[2].node, "a");
    expect_sound(plan);
}

TEST(CompileHostHistory, HostGivesASlotForEachFrame) {
    const NodeSet set = small_set();
    Target target = target_of({64, 48});
    target.inputs["motion"] = {Format::rgba16f, {32, 24}};
    const Result result = compile_text(
        set, R"("inputs": { "motion": { "history": "host", "extent": "any" } }, "outputs": ["seen"],
        "nodes": { "read": { "type": "motion_reader", "in": { "motion_prev": "motion@-1" } } })",
        target);
    ASSERT_TRUE(result.plan) << result.errors;
    ASSERT_EQ(result.plan->slots.size(), 2u);
    EXPECT_EQ(result.plan->slots[0].name, "motion");
    EXPECT_EQ(result.plan->slots[1].name, "motion@-1");
    for (const HostSlot& slot : result.plan->slots) {
        EXPECT_EQ(slot.format, Format::rgba16f);
        EXPECT_EQ(slot.extent, (Extent{32, 24}));
    }
    EXPECT_EQ(result.plan->resources.size(), 1u) << "nothing is kept";
}

TEST(CompileInputs, WithoutAHostTheFirstFormatThatAllReadersAcceptIsTaken) {
    const NodeSet set = small_set();
    const Result result =
        compile_text(set, R"("inputs": { "motion": { "history": "host" } }, "outputs": ["seen", "picked"],
        "nodes": { "read": { "type": "motion_reader", "in": { "motion_prev": "motion@-1" } }, "pick": { "type": "picky" } })",
                     target_of({64, 64}));
    ASSERT_TRUE(result.plan) << result.errors;
    for (const HostSlot& slot : result.plan->slots) EXPECT_EQ(slot.format, Format::rg16f);
}

TEST(CompileInputs, WhatTheHostBringsMustBeWhatThePipelineAsksFor) {
    const NodeSet set = small_set();
    const auto errors = [&](const char* settings, HostResource brought) {
        Target target = target_of({64, 48});
        target.inputs["motion"] = brought;
        return compile_text(set,
                            std::string(R"("inputs": { "motion": { )") + settings +
                                R"( } }, "outputs": ["picked"], "nodes": { "pick": { "type": "picky" } })",
                            target)
            .errors;
    };
    EXPECT_EQ(errors("", {Format::rg16f, {64, 48}}), "");
    EXPECT_NE(errors(R"("format": "rgba16f")", {Format::rg16f, {64, 48}})
                  .find("inputs.motion.format: the host brings rg16f"),
              std::string::npos);
    EXPECT_NE(
        errors("", {Format::rg16f, {64, 47}}).find("the host brings 64x47, the pipeline asks for 64x48"),
        std::string::npos);
    EXPECT_NE(errors(R"("extent": [8, 8])", {Format::rg16f, {64, 48}}).find("the pipeline asks for 8x8"),
              std::string::npos);
    EXPECT_EQ(errors(R"("extent": "any")", {Format::rg16f, {3, 3}}), "");
    EXPECT_NE(
        errors("", {Format::r32f, {64, 48}}).find("\"motion\" as r32f, which this port does not accept"),
        std::string::npos);
}

TEST(CompileInputs, AnOptionalInputMayBeLeftOut) {
    const NodeSet set = small_set();
    const std::string body = R"("inputs": { "mask": { "optional": true } }, "outputs": ["mixed"],
        "nodes": { "source": { "type": "source" }, "mix": { "type": "mix" } })";
    Target target = target_of({64, 64});
    EXPECT_EQ(compile_text(set, body, target).plan->slots.size(), 1u);
    target.left_out = {"mask"};
    const Plan plan = *compile_text(set, body, target).plan;
    EXPECT_TRUE(plan.slots.empty());
    EXPECT_FALSE(is_bound(pass_of(plan, "mix"), "mask"));
    EXPECT_EQ(pass_of(plan, "mix").constants.back(), 0u) << "HAS_MASK";
    const std::string required = R"("inputs": { "mask": {} }, "outputs": ["mixed"],
        "nodes": { "source": { "type": "source" }, "mix": { "type": "mix" } })";
    EXPECT_NE(compile_text(set, required, target).errors.find("it is not optional"), std::string::npos);
}

TEST(CompileFacts, PortsRuledOutByFactsAreNotBound) {
    NodeSet set = small_set();
    set.add({.type = parse_toy(R"({ "node": "tint", "doc": "d", "shader": "s.comp",
      "inputs": { "value": { "kind": "image", "format": "r16f" }, "extra": { "kind": "image", "format": "rgba16f", "if": "alpha" } },
      "outputs": { "tinted": { "kind": "image", "format": "r16f" } }, "dispatch": { "over": "frame" } })",
                               "tint")});
    const std::string body =
        R"("outputs": ["tinted"], "nodes": { "source": { "type": "source" }, "tint": { "type": "tint" } })";
    Target target = target_of({64, 64});
    EXPECT_EQ(compile_text(set, body, target).plan->resources.size(), 3u);
    target.facts["alpha"] = false;
    const Plan plan = *compile_text(set, body, target).plan;
    EXPECT_EQ(plan.resources.size(), 2u);
    EXPECT_FALSE(is_bound(pass_of(plan, "tint"), "extra"));
    EXPECT_EQ(pass_of(plan, "tint").constants.back(), 0u) << "HAS_EXTRA";
    EXPECT_FALSE(plan.facts.at("alpha"));
    EXPECT_TRUE(plan.facts.at("casters")) << "facts not named are true";
}

// One function says what the variants are: those of outputs that can exist together, formats that the code
// names, and no more for inputs and tables, whose absence is a constant.
TEST(CompileVariants, OnlyPossibleOnesAreCompiled) {
    const NodeType type = parse_toy(R"({ "node": "tint", "doc": "d", "shader": "s.comp",
      "inputs": { "a": { "kind": "image", "format": "r8", "if": "form=long" },
                  "b": { "kind": "image", "format": "r8", "optional": true } },
      "outputs": { "tinted": { "kind": "image", "format": "r16f" },
                   "c": { "kind": "image", "format": "r8", "if": "form=long & moves" },
                   "d": { "kind": "image", "format": "r8", "if": "moves & form=long" },
                   "e": { "kind": "image", "format": "r8", "if": "size>=8 | form=long" } },
      "tables": { "noise": { "file": "n.bin", "format": "r8", "extent": [2, 2], "if": "form=long & sun_disc" } },
      "params": { "form": { "type": "enum", "values": ["long", "short"], "default": "long", "constant": true, "doc": "d" },
                  "size": { "type": "uint", "default": 1, "range": [1, 8], "constant": true, "doc": "d" } },
      "dispatch": { "over": "frame" } })",
                                    "tint");
    const std::vector<Variant> variants = all_variants(type);
    std::set<std::string> keys;
    for (const Variant& v : variants) keys.insert(to_string(v));
    EXPECT_EQ(keys, (std::set<std::string>{"c=0,d=0,e=0", "c=0,d=0,e=1", "c=1,d=1,e=1"}));
    EXPECT_EQ(keys.size(), variants.size());
    const std::string glsl = generate_glsl(type, variants.front());
    for (const char* line : {"const bool HAS_A =", "const bool HAS_B =", "const bool HAS_NOISE =",
                             "#define HAS_C 0", "sampler2D noise;"})
        EXPECT_NE(glsl.find(line), std::string::npos) << line;
}

// What a texel buffer is written as depends on its format, so the chosen one is compiled, not the first.
TEST(CompileVariants, WrittenTexelsAreOfTheFormatThatThePipelineChooses) {
    NodeSet set;
    set.add({.type = parse_toy(R"({ "node": "meta", "doc": "d", "shader": "s.comp",
      "outputs": { "tiles": { "kind": "texels", "format": ["r32ui", "rg32ui"] } }, "dispatch": { "over": "frame" } })",
                               "meta")});
    const Result result = compile_text(
        set,
        R"("outputs": ["tiles"], "resources": { "tiles": { "format": "rg32ui" } }, "nodes": { "meta": { "type": "meta" } })",
        target_of({8, 8}));
    ASSERT_TRUE(result.plan) << result.errors;
    EXPECT_EQ(result.plan->passes[0].variant, "tiles=rg32ui");
    std::map<std::string, std::string> glsl;
    for (const Variant& v : all_variants(set.find("meta")->type))
        glsl[to_string(v)] = generate_glsl(set.find("meta")->type, v);
    ASSERT_EQ(glsl.size(), 2u);
    EXPECT_NE(glsl.at("tiles=rg32ui").find("uvec2 tiles[]"), std::string::npos);
    EXPECT_NE(glsl.at("tiles=r32ui").find("uint tiles[]"), std::string::npos);
}

// The host gets outputs that it can use: whoever reads them within the pipeline, or nobody.
TEST(CompileOutputs, AreMadeForWhatTheHostDoesWithThem) {
    const NodeSet set = small_set();
    const std::string body = R"("outputs": ["value"], "nodes": { "source": { "type": "source" } })";
    const Plan plan = *compile_text(set, body, target_of({64, 64})).plan;
    constexpr VkImageUsageFlags usual =
        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    EXPECT_EQ(plan.resources[0].image_usage & usual, usual);
    CompileOptions options;
    options.outputs["value"] = {.image_usage = VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT,
                                .stages = VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
                                .access = VK_ACCESS_2_INPUT_ATTACHMENT_READ_BIT};
    const Plan asked = *compile_text(set, body, target_of({64, 64}), options).plan;
    EXPECT_TRUE(asked.resources[0].image_usage & VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT);
    EXPECT_FALSE(asked.resources[0].image_usage & VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    EXPECT_EQ(asked.end[0].dst_stages, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT);
    EXPECT_EQ(asked.end[0].dst_access, VK_ACCESS_2_INPUT_ATTACHMENT_READ_BIT);
    Target target = target_of({64, 64});
    target.device.supports = [](Format, VkFormatFeatureFlags features) {
        return !(features & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT);
    };
    EXPECT_NE(compile_text(set, body, target).errors.find("cannot sample r16f, the format of \"value\""),
              std::string::npos);
}

// Not every format that can be stored to can be sampled.
TEST(CompileInputs, WhatIsSampledMustBeOfAFormatThatCanBe) {
    const NodeSet set = small_set();
    Target target = target_of({64, 64});
    target.device.supports = [](Format format, VkFormatFeatureFlags features) {
        return format != Format::r16f || !(features & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT);
    };
    const std::string nodes = R"("nodes": { "source": { "type": "source" }, "mix": { "type": "mix" } })";
    const std::string body =
        R"("outputs": ["mixed"], "resources": { "mixed": { "format": "r8" } }, )" + nodes;
    EXPECT_NE(compile_text(set, body, target)
                  .errors.find("resources.value: the device \"reference gpu\" cannot sample r16f"),
              std::string::npos)
        << compile_text(set, body, target).errors;
    EXPECT_TRUE(compile_text(set, body, target_of({64, 64})).plan);
}

TEST(CompileTarget, NamesThatThePipelineDoesNotKnowAreRefused) {
    const NodeSet set = small_set();
    const std::string body = R"("inputs": { "mask": { "optional": true } }, "outputs": ["mixed"],
        "nodes": { "source": { "type": "source" }, "mix": { "type": "mix" } })";
    const auto errors = [&](auto&& change) {
        Target target = target_of({64, 64});
        CompileOptions options;
        change(target, options);
        return compile_text(set, body, target, options).errors;
    };
    EXPECT_EQ(errors([](Target&, CompileOptions&) {}), "");
    EXPECT_NE(
        errors([](Target& t, CompileOptions&) { t.facts["move"] = false; }).find("did you mean \"moves\"?"),
        std::string::npos);
    EXPECT_NE(errors([](Target& t, CompileOptions&) { t.inputs["mas"] = {}; }).find("did you mean \"mask\"?"),
              std::string::npos);
    EXPECT_NE(
        errors([](Target& t, CompileOptions&) { t.left_out = {"masks"}; }).find("did you mean \"mask\"?"),
        std::string::npos);
    EXPECT_NE(
        errors([](Target&, CompileOptions& o) { o.outputs["mixd"] = {}; }).find("did you mean \"mixed\"?"),
        std::string::npos);
}

// A size may follow what a later pass of the frame makes: sizes are known before anything is bound.
TEST(CompileSizes, FollowAPreviousValueWhoeverWritesIt) {
    NodeSet set = small_set();
    set.add({.type = parse_toy(R"({ "node": "follow", "doc": "d", "shader": "s.comp",
      "inputs": { "before": { "kind": "image", "format": "r16f", "previous": true } },
      "outputs": { "after": { "kind": "image", "format": "r16f", "extent": { "of": "before", "div": [2, 2] } } },
      "dispatch": { "over": "after" } })",
                               "follow")});
    const Plan plan = *compile_text(set, R"("outputs": ["after", "value"], "nodes": {
        "follow": { "type": "follow", "in": { "before": "value@-1" } }, "source": { "type": "source" } })",
                                    target_of({64, 48}))
                           .plan;
    EXPECT_EQ(plan.passes.front().node, "follow");
    EXPECT_EQ(resource_of(plan, "after")->extent, (Extent{32, 24}));
    expect_sound(plan);
}

// A plan, and the checked pipeline it is made of, keep the types that they were made with.
TEST(CompileNodeSet, ATypeThatIsReplacedLastsAsLongAsWhatWasMadeOfIt) {
    NodeSet set = small_set();
    Diagnostics diagnostics;
    const auto pipeline = parse_pipeline(R"({ "penumbra": 1, "name": "p", "outputs": ["doubled"], "nodes": {
        "source": { "type": "source" }, "twice": { "type": "twice" } } })",
                                         "p.json", {}, diagnostics);
    const auto checked = check(*pipeline, set, diagnostics);
    ASSERT_TRUE(checked) << diagnostics.text();
    const auto before = compile(*checked, target_of({64, 64}), {}, diagnostics);
    const std::string text = to_text(*before);
    set.add({.type = parse_toy(R"({ "node": "source", "doc": "another", "shader": "s.comp",
      "outputs": { "other": { "kind": "buffer", "element": "u32", "count": 1 } },
      "dispatch": { "groups": [1, 1, 1], "group": [1, 1] } })",
                               "source")});
    EXPECT_EQ(to_text(*before), text);
    EXPECT_EQ(before->passes[0].params.front().param.name, "gain");
    EXPECT_EQ(to_text(*compile(*checked, target_of({64, 64}), {}, diagnostics)), text);
    EXPECT_FALSE(check(*pipeline, set, diagnostics)) << "the set itself has the new one";
}

// A family's members wait for who reads them where nothing lives longer by that; who only watches makes
// nothing live longer, and nothing has to be there early for it.
TEST(CompileOrder, WatchersDoNotChangeIt) {
    NodeSet set = small_set();
    const auto add = [&](const char* name, const std::string& ports) {
        set.add({.type = parse_toy(R"({ "node": ")" + std::string(name) +
                                       R"(", "doc": "d", "shader": "s.comp", )" + ports +
                                       R"(, "dispatch": { "over": "frame" } })",
                                   name)});
    };
    const std::string image = R"({ "kind": "image", "format": "r16f" })",
                      end = R"("outputs": { "end": )" + image + " }";
    add("of_mixed", R"("inputs": { "mixed": )" + image + R"(, "middle": )" + image + " }, " + end);
    add("of_both", R"("inputs": { "mixed": )" + image + R"(, "value": )" + image + R"(, "middle": )" + image +
                       " }, " + end);
    add("look", R"("inputs": { "value": )" + image + R"( }, "counters": ["seen"])");
    const auto order = [&](const std::string& last, const std::string& first_nodes,
                           const std::string& more_nodes) {
        const std::string of = R"("instances": "lights")";
        const Result result = compile_text(
            set,
            R"("outputs": ["end"], "instances": { "a": { "of": "lights" }, "b": { "of": "lights" } },
            "resources": { "mixed_a": { "format": "r16f" }, "mixed_b": { "format": "r16f" } }, "nodes": {)" +
                first_nodes + R"("source": { "type": "source", )" + of + R"( }, "mix": { "type": "mix", )" +
                of + R"( },
            "last": { "type": ")" +
                last + "\", " + of + R"( },
            "middle": { "type": "source", "out": { "value": "middle" } })" +
                more_nodes + " }",
            target_of({64, 64}));
        EXPECT_EQ(result.errors, "");
        std::vector<std::string> names;
        for (const PlanPass& pass : result.plan.value().passes)
            if (pass.type != "look") names.push_back(pass.node);
        return names;
    };
    using Names = std::vector<std::string>;
    const auto look_at = [](const std::string& value) {
        return R"("look_)" + value + R"(": { "type": "look", "in": { "value": ")" + value + R"(" } })";
    };
    const Names early{"source_a", "mix_a", "source_b", "mix_b", "middle", "last_a", "last_b"};
    EXPECT_EQ(order("of_mixed", "", ""), early) << "values would live longer";
    EXPECT_EQ(order("of_mixed", "", ", " + look_at("value_a") + ", " + look_at("value_b")), early);
    const Names late{"middle", "source_a", "mix_a", "last_a", "source_b", "mix_b", "last_b"};
    EXPECT_EQ(order("of_both", "", ""), late);
    EXPECT_EQ(order("of_both", look_at("mixed_a") + ", " + look_at("mixed_b") + ", ", ""), late);
}

TEST(CompileNodeSet, HasOneDomain) {
    NodeSet set = small_set();
    NodeEntry foreign = *set.find("source");
    foreign.type.domain = std::make_shared<Domain>(*foreign.type.domain);
    EXPECT_THROW(set.add(foreign), std::invalid_argument);
    NodeSet told(std::make_shared<Domain>());  // which has no facts, but is one
    EXPECT_THROW(told.add(foreign), std::invalid_argument);
}

// A declaration alone can be planned with; nothing else's shader stands in for its own.
TEST(CompileNodeSet, ATypeWithoutAShaderHasNoModule) {
    NodeSet set = small_set();
    NodeEntry source = *set.find("source");
    for (const Variant& variant : all_variants(source.type)) source.shaders[to_string(variant)] = {0};
    set.add(source);
    const Result result = compile_text(set, R"("outputs": ["doubled"], "nodes": {
        "source": { "type": "source" }, "twice": { "type": "twice" } })",
                                       target_of({64, 64}));
    ASSERT_TRUE(result.plan) << result.errors;
    EXPECT_EQ(pass_of(*result.plan, "source").module, 0u);
    EXPECT_FALSE(pass_of(*result.plan, "twice").module);
}

TEST(CompileHostNodes, TheirCallbacksAreSynchronisedAsIfTheyDidAnything) {
    NodeSet set = small_set();
    set.add({.type = parse_toy(R"({ "node": "engine", "doc": "d", "host": true,
      "inputs": { "value": { "kind": "image", "format": "r16f" } },
      "outputs": { "drawn": { "kind": "image", "format": "r16f" } } })",
                               "engine")});
    const Plan plan = *compile_text(set, R"("outputs": ["drawn"], "nodes": { "source": { "type": "source" },
        "engine": { "type": "engine" } })",
                                    target_of({64, 64}))
                           .plan;
    const Dependency& before = pass_of(plan, "engine").before[0];
    EXPECT_EQ(before.dst_stages & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
    EXPECT_TRUE(before.dst_access & VK_ACCESS_2_MEMORY_READ_BIT);
    EXPECT_TRUE(resource_of(plan, "value")->image_usage & VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    EXPECT_TRUE(resource_of(plan, "drawn")->image_usage & VK_IMAGE_USAGE_TRANSFER_DST_BIT);
    expect_sound(plan);
}

// Texel buffers: whole words, and not larger than the device can read.
TEST(CompileTexels, NarrowTexelsTakeWholeWordsAndTheDeviceLimitsTheirNumber) {
    NodeSet set;
    set.add({.type = parse_toy(R"({ "node": "meta", "doc": "d", "shader": "s.comp",
      "outputs": { "tiles": { "kind": "texels", "format": "r8" } }, "dispatch": { "over": "frame" } })",
                               "meta")});
    set.add({.type = parse_toy(R"({ "node": "use", "doc": "d", "shader": "s.comp",
      "inputs": { "tiles": { "kind": "texels", "format": "r8" } },
      "outputs": { "used": { "kind": "image", "format": "r16f" } }, "dispatch": { "over": "frame" } })",
                               "use")});
    const std::string body =
        R"("outputs": ["used"], "nodes": { "meta": { "type": "meta" }, "use": { "type": "use" } })";
    Target target = target_of({5, 3});
    EXPECT_EQ(resource_of(*compile_text(set, body, target).plan, "tiles")->buffer_bytes(), 16u);
    target.device.max_texel_elements = 14;
    EXPECT_NE(
        compile_text(set, body, target).errors.find("15 texels exceed the device's largest texel buffer, 14"),
        std::string::npos);
    target.device = reference_device();
    target.device.max_storage_bytes = 15;
    EXPECT_NE(
        compile_text(set, body, target).errors.find("16 bytes exceed the device's largest storage buffer"),
        std::string::npos);
}

TEST(CompileLayers, AnArrayTakesItsLayersFromThePortThatGivesItsExtent) {
    NodeSet set;
    set.add({.type = parse_toy(R"({ "node": "bounds", "doc": "d", "shader": "s.comp",
      "inputs": { "maps": { "kind": "image", "format": "d32", "layers": true } },
      "outputs": { "low": { "kind": "image", "format": "r32f", "layers": true, "extent": { "of": "maps", "div": [2, 2] } } },
      "dispatch": { "over": "low" } })",
                               "bounds")});
    Target target = target_of({64, 64});
    target.inputs["maps"] = {Format::d32, {512, 512}, 4};
    const Plan plan = *compile_text(set, R"("inputs": { "maps": { "extent": "any" } }, "outputs": ["low"],
        "nodes": { "bounds": { "type": "bounds" } })",
                                    target)
                           .plan;
    EXPECT_EQ(plan.slots[0].layers, 4u);
    EXPECT_EQ(plan.resources[0].layers, 4u);
    EXPECT_TRUE(plan.resources[0].layered);
    EXPECT_EQ(plan.resources[0].bytes, 4u * 256 * 256 * 4);
}

TEST(CompileLayers, AnArrayHasALayerForEachRowOfTexels) {
    NodeSet set;
    set.add({.type = parse_toy(R"({ "node": "slices", "doc": "d", "shader": "s.comp",
      "inputs": { "list": { "kind": "texels", "format": "r32ui" } },
      "outputs": { "slice": { "kind": "image", "format": "r32f", "layers": true, "layers_of": "list" } },
      "dispatch": { "over": "frame" } })",
                               "slices")});
    Target target = target_of({64, 32});
    target.inputs["list"] = {Format::r32ui, {5, 7}};
    const Plan plan = *compile_text(set, R"("inputs": { "list": { "extent": "any" } }, "outputs": ["slice"],
        "nodes": { "slices": { "type": "slices" } })",
                                    target)
                           .plan;
    EXPECT_EQ(plan.resources[0].layers, 7u);
    EXPECT_TRUE(plan.resources[0].layered);
    EXPECT_EQ(plan.resources[0].extent, (Extent{64, 32}));
    EXPECT_EQ(plan.resources[0].bytes, 7u * 64 * 32 * 4);
    EXPECT_EQ(plan.passes[0].groups,
              (std::array<uint32_t, 3>{8, 4, 1}));  // over the frame, not over the layers
}

TEST(CompileIndirect, ArgumentsMustFitAndBeOfThisFrame) {
    NodeSet set;
    set.add({.type = parse_toy(R"({ "node": "list", "doc": "d", "shader": "s.comp",
      "outputs": { "args": { "kind": "buffer", "element": "u32", "count": 3, "indirect": true } },
      "dispatch": { "groups": [1, 1, 1], "group": [1, 1] } })",
                               "list")});
    const auto run = [](int offset) {
        return R"({ "node": "run", "doc": "d", "shader": "s.comp",
      "inputs": { "args": { "kind": "buffer", "element": "u32", "indirect": true } },
      "outputs": { "done": { "kind": "image", "format": "r16f" } },
      "dispatch": { "indirect": "args", "offset": )" +
               std::to_string(offset) + R"(, "group": [8, 8] } })";
    };
    const std::string nodes =
        R"("outputs": ["done"], "nodes": { "list": { "type": "list" }, "run": { "type": "run" } })";
    set.add({.type = parse_toy(run(0), "run")});
    EXPECT_TRUE(compile_text(set, nodes, target_of({64, 64})).plan);
    const std::string previous =
        R"("outputs": ["done"], "nodes": { "run": { "type": "run", "in": { "args": "args@-1" } },
        "list": { "type": "list" } })";
    try {
        (void)compile_text(set, previous, target_of({64, 64}));
        ADD_FAILURE() << "check() finds it, so that compile() need not";
    } catch (const std::runtime_error& error) {
        EXPECT_NE(std::string(error.what()).find("of the same frame"), std::string::npos) << error.what();
    }
    set.add({.type = parse_toy(run(4), "run")});
    EXPECT_NE(compile_text(set, nodes, target_of({64, 64}))
                  .errors.find("too small for dispatch arguments at byte 4"),
              std::string::npos);
}

TEST(Compile, EarlierDiagnosticsAreNotItsOwn) {
    const NodeSet set = small_set();
    Diagnostics diagnostics;
    diagnostics.add({}, "elsewhere", "a mistake in another file");
    Diagnostics none;
    const auto pipeline = parse_pipeline(R"({ "penumbra": 1, "name": "p", "outputs": ["value"],
        "nodes": { "source": { "type": "source" } } })",
                                         "p.json", {}, none);
    const auto checked = check(*pipeline, set, none);
    ASSERT_TRUE(checked) << none.text();
    EXPECT_TRUE(compile(*checked, target_of({64, 64}), {}, diagnostics));
}

TEST(Compile, AnEmptyFrameIsAnError) {
    const NodeSet set = small_set();
    EXPECT_NE(compile_text(set, R"("outputs": ["value"], "nodes": { "source": { "type": "source" } })",
                           target_of({0, 64}))
                  .errors.find("the frame's extent is empty"),
              std::string::npos);
}

}  // namespace
}  // namespace penumbra::test
