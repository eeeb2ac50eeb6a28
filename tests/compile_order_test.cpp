// SPDX-License-Identifier: MIT
// Who runs before whom, and what memory is shared or lasts by it: updates, what is kept, resets, families.
#include <gtest/gtest.h>

#include "tests/compile_text.h"
#include "tests/toy_nodes.h"

namespace penumbra::test {
namespace {

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
    const Plan any =
        *compile_text(set, R"("outputs": ["late", "two"], "resources": { "value": { "first": "clear" } },
        "nodes": { "source": { "type": "source" }, "a": { "type": "twice", "out": { "doubled": "two" } },
          "mix": { "type": "mix", "in": { "value": "two", "before": "two@-1" }, "out": { "mixed": "late" } } })",
                      target_of({64, 64}))
             .plan;
    EXPECT_FALSE(resource_of(any, "two")->clear_on_reset) << "that of another name is not";
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
        const CompiledText result = compile_text(
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

}  // namespace
}  // namespace penumbra::test
