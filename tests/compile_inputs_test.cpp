// SPDX-License-Identifier: MIT
// What compile() makes of what a host brings, promises and wants: inputs, facts, outputs.
#include <gtest/gtest.h>

#include "tests/compile_text.h"
#include "tests/toy_nodes.h"

namespace penumbra::test {
namespace {

TEST(CompileOutputs, AnOptionalOutputExistsOnlyWhereItIsAskedFor) {
    const NodeSet set = small_set();
    const std::string nodes = R"("nodes": { "source": { "type": "source", "out": { "extra": "more" } } })";
    const CompiledText without = compile_text(set, R"("outputs": ["value"], )" + nodes, target_of({64, 64}));
    EXPECT_FALSE(resource_of(*without.plan, "more"));
    EXPECT_EQ(pass_of(*without.plan, "source").variant, "extra=0");
    const CompiledText with =
        compile_text(set, R"("outputs": ["value", "more"], )" + nodes, target_of({64, 64}));
    EXPECT_TRUE(resource_of(*with.plan, "more"));
    EXPECT_EQ(pass_of(*with.plan, "source").variant, "extra=1");
    CompileOptions options;
    options.captures = {"more"};
    const CompiledText captured =
        compile_text(set, R"("outputs": ["value"], )" + nodes, target_of({64, 64}), options);
    EXPECT_TRUE(resource_of(*captured.plan, "more"));
}

TEST(CompileHostHistory, HostGivesASlotForEachFrame) {
    const NodeSet set = small_set();
    Target target = target_of({64, 48});
    target.inputs["motion"] = {Format::rgba16f, {32, 24}};
    const CompiledText result = compile_text(
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
    const CompiledText result =
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

// What a view binds may be larger than the frame; what a plan is told is the frame's own size.
TEST(CompileInputs, AnImageLargerThanTheFrameIsNotDeclared) {
    Target target = target_of({64, 36});
    target.inputs["motion"] = {Format::rg16f, {128, 72}};
    const std::string text = compile_text(small_set(), R"("inputs": { "motion": {} }, "outputs": ["picked"],
        "nodes": { "pick": { "type": "picky" } })",
                                          target)
                                 .errors;
    EXPECT_NE(text.find("asks for 64x36, the frame's own size; what is bound to it may be larger"),
              std::string::npos)
        << text;
}

TEST(CompileInputs, ArraysAreBroughtWhereAPortTakesThem) {
    Target target = target_of({64, 64});
    target.inputs["motion"] = {Format::rg16f, {64, 64}, 7};
    const char* body =
        R"("inputs": { "motion": {} }, "outputs": ["picked"], "nodes": { "pick": { "type": "picky" } })";
    const std::string text = compile_text(small_set(), body, target).errors;
    EXPECT_NE(text.find("the host brings \"motion\" with 7 layers, and this port takes no array"),
              std::string::npos)
        << text;
    target.inputs["motion"].layers = 0;
    EXPECT_NE(compile_text(small_set(), body, target).errors.find("an image of 64x64 and 0 layers"),
              std::string::npos);
    target.inputs["motion"].layers = 1;
    EXPECT_FALSE(compile_text(small_set(), body, target).plan->slots[0].layered);
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
    // What the host writes in place is over before the memory is another's.
    options.outputs["value"] = {.stages = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                                .access = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT};
    const Plan written = *compile_text(set, body, target_of({64, 64}), options).plan;
    EXPECT_TRUE(written.outputs[0].use.write);
    EXPECT_EQ(written.passes[0].before[0].activations.at(0).src_access,
              VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT);
    options.outputs["value"].image_usage = VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT;
    Target target = target_of({64, 64});
    target.device.supports = [](Format, VkFormatFeatureFlags features) {
        return !(features & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT);
    };
    EXPECT_NE(compile_text(set, body, target).errors.find("outputs.value: the device"), std::string::npos);
    target.device.supports = [](Format, VkFormatFeatureFlags features) {
        return !(features & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT);
    };
    EXPECT_EQ(compile_text(set, body, target, options).errors, "");
    options.outputs["value"].image_usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    EXPECT_NE(compile_text(set, body, target, options).errors.find("outputs.value: the device"),
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
    EXPECT_NE(errors([](Target& t, CompileOptions&) {
                  t.device.features = {"storage8", "ray_querys"};
              }).find("did you mean \"ray_query\"?"),
              std::string::npos);
}

}  // namespace
}  // namespace penumbra::test
