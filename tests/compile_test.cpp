// SPDX-License-Identifier: MIT
// What compile() decides, on node sets made for each question and without a device: which variants, formats,
// sizes and constants, and what is refused.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <set>

#include "graph/interface.h"
#include "tests/compile_text.h"
#include "tests/toy_nodes.h"

namespace penumbra::test {
namespace {

TEST(CompileVariants, AnAbsentPortWithAChoiceOfFormatsStillNamesACompiledVariant) {
    NodeSet set = small_set();
    NodeEntry mix = *set.find("mix");
    for (const Variant& variant : all_variants(mix.type)) mix.shaders[to_string(variant)] = {0};
    set.add(mix);
    const CompiledText result = compile_text(set, R"("outputs": ["mixed"], "nodes": {
        "source": { "type": "source" }, "mix": { "type": "mix" } })",
                                             target_of({64, 64}));
    ASSERT_TRUE(result.plan) << result.errors;
    EXPECT_FALSE(is_bound(pass_of(*result.plan, "mix"), "before"));
}

TEST(CompileVariants, TheWritersFormatChoosesTheReadersVariant) {
    const NodeSet set = small_set();
    const CompiledText result =
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
    // Workgroup, pixels per thread, ON_CPU, LANES_IN_STEP, taps.
    EXPECT_EQ(gpu.passes[0].constants, (std::vector<uint32_t>{8, 8, 1, 1, 1, 0, 1, 4}));
    EXPECT_EQ(cpu.passes[0].constants, (std::vector<uint32_t>{64, 1, 1, 1, 2, 1, 1, 9}));
    Target in_step = target_of({640, 480}, true);
    in_step.device.lanes_in_step = 8;
    EXPECT_EQ(compile_text(set, body, in_step).plan->passes[0].constants,
              (std::vector<uint32_t>{64, 1, 1, 1, 2, 1, 8, 9}));
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

TEST(CompileVariants, AShaderMayBeCompiledForEachClass) {
    NodeSet set;
    set.add({.type = parse_toy(R"({ "node": "tint", "doc": "d", "shader": "s.comp",
      "outputs": { "tinted": { "kind": "image", "format": "r8" } }, "dispatch": { "over": "frame" },
      "classes": { "compiled": true } })",
                               "tint")});
    const NodeType& type = set.find("tint")->type;
    std::map<std::string, std::string> glsl;
    for (const Variant& v : all_variants(type)) glsl[to_string(v)] = generate_glsl(type, v);
    ASSERT_EQ(glsl.size(), 2u);
    EXPECT_NE(glsl.at("class=cpu").find("#define CLASS_CPU 1\n"), std::string::npos);
    EXPECT_NE(glsl.at("class=gpu").find("#define CLASS_CPU 0\n"), std::string::npos);
    for (const bool cpu : {false, true}) {
        const CompiledText result = compile_text(
            set, R"("outputs": ["tinted"], "nodes": { "tint": { "type": "tint" } })", target_of({8, 8}, cpu));
        ASSERT_TRUE(result.plan) << result.errors;
        EXPECT_EQ(result.plan->passes[0].variant, cpu ? "class=cpu" : "class=gpu");
    }
}

// What a texel buffer is written as depends on its format, so the chosen one is compiled, not the first.
TEST(CompileVariants, WrittenTexelsAreOfTheFormatThatThePipelineChooses) {
    NodeSet set;
    set.add({.type = parse_toy(R"({ "node": "meta", "doc": "d", "shader": "s.comp",
      "outputs": { "tiles": { "kind": "texels", "format": ["r32ui", "rg32ui"] } }, "dispatch": { "over": "frame" } })",
                               "meta")});
    const CompiledText result = compile_text(
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
TEST(CompileSizes, AreNeverCountedPastTheLargestNumber) {
    const Follows twice{.steps = {{{1, 1}, {65536, 1}}, {{1, 1}, {65536, 1}}}};
    EXPECT_EQ(twice.at({64, 2}).width, UINT32_MAX);
    EXPECT_EQ(twice.at({64, 2}).height, 2u);
}

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

TEST(CompileNodeSet, HasOneDomain) {
    NodeSet set = small_set();
    NodeEntry foreign = *set.find("source");
    foreign.type.domain = std::make_shared<Domain>(*foreign.type.domain);
    EXPECT_THROW(set.add(foreign), std::invalid_argument);
    NodeSet told(std::make_shared<Domain>());  // which has no facts, but is one
    EXPECT_THROW(told.add(foreign), std::invalid_argument);
    Domain odd;  // nothing can be bound in place of its structure
    odd.bundles = {{.kind = "scene", .parts = {{.kind = PortKind::structure, .fact = "alpha"}}}};
    EXPECT_THROW(NodeSet(std::make_shared<Domain>(odd)), std::invalid_argument);
    odd.bundles[0].parts[0].fact.clear();
    EXPECT_NO_THROW(NodeSet(std::make_shared<Domain>(odd)));
}

// A past per pixel is that of whatever a pixel shows: where frames are jittered, who keeps one where nothing
// moves asks for one of surfaces, for the whole plan. `past` runs only where what `camera` makes is read.
TEST(CompileJitter, FactsHoldForWhoIsJittered) {
    NodeSet set = small_set();
    set.add({.type = parse_toy(R"({ "node": "past", "doc": "d", "shader": "s.comp", "jittered": ["moves"],
      "inputs": { "value": { "kind": "image", "format": "r16f" },
                  "moved": { "kind": "image", "format": "r16f", "if": "moves" } },
      "outputs": { "kept": { "kind": "image", "format": "r16f" } }, "dispatch": { "over": "frame" } })",
                               "past")});
    set.add({.type = parse_toy(R"({ "node": "camera", "doc": "d", "shader": "s.comp",
      "outputs": { "moved": { "kind": "image", "format": "r16f" } }, "dispatch": { "over": "frame" } })",
                               "camera")});
    set.add({.type = parse_toy(R"({ "node": "smooth", "doc": "d", "shader": "s.comp", "needs": ["jitter"],
      "inputs": { "kept": { "kind": "image", "format": "r16f" } },
      "outputs": { "smoothed": { "kind": "image", "format": "r16f" } }, "dispatch": { "over": "frame" } })",
                               "smooth")});
    const std::string nodes = R"("nodes": { "source": { "type": "source" }, "camera": { "type": "camera" },
        "past": { "type": "past" }, "smooth": { "type": "smooth" } })";
    const auto plan = [&](const char* output, std::optional<bool> jitters, bool moves,
                          const CompileOptions& options = {}) {
        Target target = target_of({64, 64});
        target.facts["moves"] = moves;
        target.jitters = jitters;
        CompiledText result =
            compile_text(set, fmt::format(R"("outputs": ["{}"], {})", output, nodes), target, options);
        if (!result.plan) throw std::runtime_error(result.errors);
        return std::move(*result.plan);
    };
    struct Case {
        const char* output;
        std::optional<bool> jitters;
        bool moves, plan_jitters, plan_moves;
    };
    for (const Case& c : std::vector<Case>{{"smoothed", {}, false, true, true},
                                           {"smoothed", false, false, false, false},
                                           {"smoothed", {}, true, true, true},
                                           {"kept", {}, false, false, false},
                                           {"kept", true, false, true, true},
                                           {"value", true, false, true, false}}) {
        SCOPED_TRACE(fmt::format("{} {} {}", c.output,
                                 c.jitters ? *c.jitters ? "jitters" : "does not" : "as asked", c.moves));
        const Plan made = plan(c.output, c.jitters, c.moves);
        EXPECT_EQ(made.jitter, c.plan_jitters);
        EXPECT_EQ(made.facts.at("moves"), c.plan_moves);
        EXPECT_EQ(made.pass("camera") != nullptr, c.plan_moves && made.pass("past"));
    }
    CompileOptions captured;
    captured.captures = {"moved"};
    EXPECT_TRUE(plan("smoothed", {}, false, captured).pass("camera")) << "it is there once the fact holds";
    captured.captures = {"smoothed"};
    EXPECT_TRUE(plan("value", {}, false, captured).pass("camera")) << "what is captured is jittered, too";
}

// A declaration alone can be planned with; nothing else's shader stands in for its own.
TEST(CompileNodeSet, ATypeWithoutAShaderHasNoModule) {
    NodeSet set = small_set();
    NodeEntry source = *set.find("source");
    for (const Variant& variant : all_variants(source.type)) source.shaders[to_string(variant)] = {0};
    set.add(source);
    const CompiledText result = compile_text(set, R"("outputs": ["doubled"], "nodes": {
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

// A callback asks for what it changes by either name.
TEST(CompileHostNodes, WhatIsUpdatedIsBoundToTheInputToo) {
    NodeSet set = small_set();
    set.add({.type = parse_toy(R"({ "node": "engine", "doc": "d", "host": true,
      "inputs": { "value": { "kind": "image", "format": "r16f" } },
      "outputs": { "drawn": { "kind": "image", "updates": "value" } } })",
                               "engine")});
    const CompiledText made =
        compile_text(set, R"("outputs": ["drawn"], "nodes": { "source": { "type": "source" },
        "engine": { "type": "engine" } })",
                     target_of({64, 64}));
    ASSERT_TRUE(made.plan) << made.errors;
    const PlanPass& pass = pass_of(*made.plan, "engine");
    ASSERT_TRUE(pass.binding("value") && pass.binding("drawn"));
    EXPECT_EQ(pass.binding("value")->index, pass.binding("drawn")->index);
    EXPECT_FALSE(pass.binding("value")->output);
    EXPECT_TRUE(pass.binding("drawn")->output);
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
    EXPECT_TRUE(plan.slots[0].layered);
    EXPECT_EQ(plan.resources[0].layers, 4u);
    EXPECT_TRUE(plan.resources[0].layered);
    EXPECT_EQ(plan.resources[0].bytes, 4u * 256 * 256 * 4);
}

TEST(CompileLayers, AnArrayHasALayerForEachRowOfTexels) {
    NodeSet set;
    set.add({.type = parse_toy(R"({ "node": "slices", "doc": "d", "shader": "s.comp",
      "inputs": { "list": { "kind": "texels", "format": "r32ui", "row": 5 } },
      "outputs": { "slice": { "kind": "image", "format": "r32f", "layers": true, "layers_of": "list" } },
      "dispatch": { "over": "frame" } })",
                               "slices")});
    const std::string body = R"("inputs": { "list": { "extent": "any" } }, "outputs": ["slice"],
        "nodes": { "slices": { "type": "slices" } })";
    Target target = target_of({64, 32});
    target.inputs["list"] = {Format::r32ui, {5, 7}};
    const Plan plan = *compile_text(set, body, target).plan;
    EXPECT_EQ(plan.resources[0].layers, 7u);
    EXPECT_TRUE(plan.resources[0].layered);
    EXPECT_EQ(plan.resources[0].extent, (Extent{64, 32}));
    EXPECT_EQ(plan.resources[0].bytes, 7u * 64 * 32 * 4);
    EXPECT_EQ(plan.passes[0].groups,
              (std::array<uint32_t, 3>{8, 4, 1}));  // over the frame, not over the layers
    target.inputs["list"] = {Format::r32ui, {35, 1}};
    EXPECT_NE(compile_text(set, body, target)
                  .errors.find("the host brings \"list\" in rows of 35 texels, which are of 5 here"),
              std::string::npos);
    target.inputs["list"] = {Format::r32ui, {5, 5000}};
    target.device.image_memory = [](const ImageNeed&) -> MemoryNeed { throw std::logic_error("asked"); };
    EXPECT_NE(compile_text(set, body, target)
                  .errors.find("slice: it takes 5000 of maxImageArrayLayers, 2952 more than the 2048"),
              std::string::npos);
    target.inputs.clear();
    const std::string untold = compile_text(set, body, target).errors;
    EXPECT_NE(
        untold.find("inputs.list.extent: \"slice\" has a layer for each of its rows: say how many, as in "
                    "Target::inputs[\"list\"] = {Format::r32ui, {5, ROWS}}"),
        std::string::npos)
        << untold;
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
