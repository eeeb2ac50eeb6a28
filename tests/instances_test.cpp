// SPDX-License-Identifier: MIT
// Families of instances: what a pipeline says once stands there for each member, and nothing else changes.
#include <gtest/gtest.h>

#include <algorithm>

#include "penumbra/check.h"
#include "tests/toy_nodes.h"

namespace penumbra {
namespace {

// One light's nodes for each of two; `more` is put behind the keys.
std::string pipeline(const std::string& more = "",
                     const std::string& instances = R"("a": {"of": "lights"}, "b": {"of": "lights"})") {
    return R"({"penumbra": 1, "name": "p",
  "inputs": { "depth": {}, "normal": {}, "motion": {}, "sun": { "instances": "lights" }, "scene": {} },
  "outputs": ["visibility"],
  "instances": {)" +
           instances + R"(},
  "nodes": {
    "guides":   { "type": "guides" },
    "classify": { "type": "classify", "instances": "lights" },
    "trace":    { "type": "trace", "instances": "lights" },
    "denoise":  { "type": "denoise", "instances": "lights", "in": { "words": "traced", "history": "half@-1" } },
    "filter0":  { "type": "filter", "instances": "lights", "out": { "filtered": "half" } },
    "filter1":  { "type": "filter", "instances": "lights", "in": { "signal": "half" }, "out": { "filtered": "visibility" } }
  })" + more +
           "}";
}

class Instances : public ::testing::Test {
  protected:
    std::optional<CheckedPipeline> run(const std::string& text,
                                       const std::vector<std::string>& settings = {}) {
        diagnostics_ = {};
        const auto parsed = parse_pipeline(text, "p.json", settings, diagnostics_);
        return parsed ? check(*parsed, nodes_, diagnostics_) : std::nullopt;
    }
    // The one error's path and message, or all the text where there is not exactly one.
    std::string error(const std::string& text, const std::vector<std::string>& settings = {}) {
        EXPECT_FALSE(run(text, settings)) << text;
        if (diagnostics_.size() != 1) return diagnostics_.text();
        return diagnostics_.list()[0].path + ": " + diagnostics_.list()[0].message;
    }
    static std::string bound_to(const CheckedPipeline& checked, const std::string& id,
                                const std::string& port) {
        for (const BoundNode& node : checked.nodes)
            if (node.id == id)
                for (const BoundPort& bound : node.ports)
                    if (bound.port->name == port)
                        return bound.resource == no_resource ? "" : checked.name_of(bound);
        return "no port " + id + "." + port;
    }
    static const BoundNode& node(const CheckedPipeline& checked, const std::string& id) {
        return *std::ranges::find(checked.nodes, id, &BoundNode::id);
    }

    NodeSet nodes_ = test::toy_nodes();
    Diagnostics diagnostics_;
};

TEST_F(Instances, HaveTheirOwnNodesAndNamesAndShareTheRest) {
    const auto checked = run(pipeline());
    ASSERT_TRUE(checked) << diagnostics_.text();
    EXPECT_EQ(checked->nodes.size(), 1 + 2 * 5);
    EXPECT_EQ(checked->output_names(), (std::vector<std::string>{"visibility_a", "visibility_b"}));
    for (const std::string member : {"a", "b"}) {
        EXPECT_EQ(bound_to(*checked, "trace_" + member, "hits"), "hits_" + member);
        EXPECT_EQ(bound_to(*checked, "denoise_" + member, "words"), "traced_" + member);
        EXPECT_EQ(bound_to(*checked, "denoise_" + member, "history"), "half_" + member + "@-1");
        EXPECT_EQ(bound_to(*checked, "classify_" + member, "sun"), "sun_" + member);
        EXPECT_EQ(bound_to(*checked, "classify_" + member, "view_depth"), "view_depth")
            << "what guides makes";
        EXPECT_EQ(bound_to(*checked, "classify_" + member, "debug"), "") << "nobody asks for it";
    }
    std::string order;
    for (const BoundNode& each : checked->nodes) order += each.id.back();
    EXPECT_EQ(order, "saaaaabbbbb") << "so that b's transients take the memory of a's";
    const auto of_one = run(pipeline("", R"("a": {"of": "lights"})"));
    ASSERT_TRUE(of_one) << diagnostics_.text();
    EXPECT_EQ(of_one->nodes.size(), 1 + 5);
}

TEST_F(Instances, AnOptionalOutputIsItsInstancesWhereSomebodyAsks) {
    const auto checked = run(pipeline(), {"outputs=[\"debug\", \"visibility\"]"});
    ASSERT_TRUE(checked) << diagnostics_.text();
    EXPECT_EQ(bound_to(*checked, "classify_a", "debug"), "debug_a");
    EXPECT_EQ(bound_to(*checked, "classify_b", "debug"), "debug_b");
    EXPECT_TRUE(run(pipeline(), {"outputs=[\"visibility_b\"]"})) << diagnostics_.text();
}

// Whoever reads a shared thing does not get the output of that name instead.
TEST_F(Instances, AnOptionalOutputTakesNobodysName) {
    EXPECT_FALSE(run(pipeline(), {"inputs.debug={}", R"(nodes.filter0.in.signal="debug")"}));
    EXPECT_NE(diagnostics_.text().find("nodes.classify_a.out.debug: \"debug\" is a host input"),
              std::string::npos)
        << diagnostics_.text();
}

TEST_F(Instances, SettingsAreForEach) {
    const auto checked = run(pipeline(R"(, "resources": {"half": {"first": "clear"}})"));
    ASSERT_TRUE(checked) << diagnostics_.text();
    for (const char* name : {"half_a", "half_b"})
        EXPECT_EQ(checked->resource(name)->first, First::clear) << name;
    for (const char* both : {R"("half": {"first": "clear", "format": "r16f"}, "half_a": {"first": "any"})",
                             R"("half_a": {"first": "any"}, "half": {"first": "clear", "format": "r16f"})"}) {
        const auto own = run(pipeline(std::string(R"(, "resources": {)") + both + "}"));
        ASSERT_TRUE(own) << diagnostics_.text();
        EXPECT_EQ(own->resource("half_a")->first, First::any) << both;
        EXPECT_EQ(own->resource("half_b")->first, First::clear) << both;
        for (const char* name : {"half_a", "half_b"})
            EXPECT_EQ(own->resource(name)->format, Format::r16f) << both;
    }
}

// What one member knows of itself holds for its nodes and their ports, and for nobody else's.
TEST_F(Instances, FactsAreTheirNodesOwn) {
    const auto checked =
        run(pipeline("", R"("a": {"of": "lights", "facts": {"casters": false}}, "b": {"of": "lights"})"),
            {"nodes.trace.if=casters", "outputs=[\"traced_b\"]"});
    EXPECT_FALSE(checked) << "b has no trace where there are no casters";
    const auto known = run(pipeline("", R"("a": {"of": "lights", "facts": {"casters": false}},
                                           "b": {"of": "lights", "facts": {"casters": true}})"),
                           {"nodes.trace.if=casters", "outputs=[\"traced_b\"]", R"(nodes.denoise=null)",
                            R"(nodes.filter0=null)", R"(nodes.filter1=null)"});
    ASSERT_TRUE(known) << diagnostics_.text();
    EXPECT_TRUE(node(*known, "trace_a").cases.none());
    EXPECT_TRUE(node(*known, "trace_b").cases.all());
    EXPECT_TRUE(node(*known, "guides").cases.all());
}

TEST_F(Instances, ConditionsAskForTheirOwnNodesParameters) {
    const auto checked = run(pipeline(), {"nodes.filter1.if=filter0.step=1"});
    EXPECT_TRUE(checked) << diagnostics_.text();
    EXPECT_EQ(error(pipeline(), {"nodes.guides.if=filter0.step=1"}),
              "nodes.guides.if: no node \"filter0\"; did you mean \"filter0_a\"?");
}

// A sum over a family: each member's node adds to what the one before it has, and the last one's is of all.
TEST_F(Instances, AMemberReadsTheOneBeforeAndAnyoneTheLast) {
    const std::string all =
        R"(nodes.all={"type": "filter", "in": {"signal": "SIGNAL"}, "out": {"filtered": "whole"}})";
    const auto with_signal = [&](const std::string& signal) {
        return std::string(all).replace(all.find("SIGNAL"), 6, signal);
    };
    const auto checked =
        run(pipeline(), {R"(instances.c={"of": "lights"})", R"(nodes.filter0.in.meta="meta@before")",
                         R"(nodes.filter1.in.meta="meta@last")", with_signal("visibility@last")});
    ASSERT_TRUE(checked) << diagnostics_.text();
    EXPECT_EQ(bound_to(*checked, "filter0_a", "meta"), "");
    EXPECT_EQ(bound_to(*checked, "filter0_b", "meta"), "meta_a");
    EXPECT_EQ(bound_to(*checked, "filter0_c", "meta"), "meta_b");
    for (const char* id : {"filter1_a", "filter1_b", "filter1_c"})
        EXPECT_EQ(bound_to(*checked, id, "meta"), "meta_c");
    EXPECT_EQ(bound_to(*checked, "all", "signal"), "visibility_c");
    EXPECT_EQ(error(pipeline(), {R"(nodes.filter1.in.signal="half@before")"}),
              "nodes.filter1_a.in.signal: only an optional port may be unbound (null)");
    EXPECT_EQ(error(pipeline(), {R"(nodes.filter1.in.meta="view_depth@last")"}),
              "nodes.filter1.in.meta: no family has a \"view_depth\" for each of its members");
    EXPECT_EQ(
        error(pipeline(), {with_signal("half@before")}),
        "nodes.all.in.signal: \"half\" is of \"lights\", of which the node is none; there is \"half@last\"");
    EXPECT_EQ(error(pipeline(), {R"(nodes.filter1.in.signal="half@next")"}),
              "nodes.filter1.in.signal: no \"@next\"; there are @-1, @before and @last");
}

TEST_F(Instances, MistakesAreSaid) {
    EXPECT_EQ(error(pipeline("", R"("a": {"of": "lihgts"})")).substr(0, 75),
              "p.json:2:78: inputs.sun.instances: no instance is of \"lights\"; did you mean");
    EXPECT_EQ(error(pipeline("", R"("a": {"of": "lights"}, "b": {"of": "lihgts"})")),
              "instances.b: no input and no node is of the family \"lihgts\"; did you mean \"lights\"?");
    // Whose last member is asked for by a node of no family.
    EXPECT_EQ(error(pipeline("", ""), {R"(nodes.all={"type": "filter", "in": {"signal": "visibility@last"}, )"
                                       R"("out": {"filtered": "whole"}})"})
                  .substr(0, 57),
              "p.json:2:78: inputs.sun.instances: no instance is of \"lig");
    EXPECT_EQ(error(pipeline("", R"("a": {})")), "instances.a: key \"of\" is missing");
    EXPECT_EQ(error(pipeline("", R"("a": {"of": "lights", "facts": {"caster": true}})")).substr(0, 47),
              "instances.a.facts.caster: no fact \"caster\" (fac");
    EXPECT_EQ(error(pipeline("", R"("a": {"of": "lights", "facts": {"casters": 1}})")),
              "instances.a.facts.casters: expected a boolean, got an integer");
    EXPECT_EQ(error(pipeline(), {"nodes.filter2={\"type\": \"filter\", \"in\": {\"signal\": \"visibility\"}, "
                                 "\"out\": {\"filtered\": \"softer\"}}"}),
              "nodes.filter2.in.signal: there is one \"visibility\" for each of \"lights\": "
              "\"visibility_INSTANCE\"");
    EXPECT_EQ(error(pipeline(), {"nodes.filter2={\"type\": \"filter\", \"in\": {\"signal\": \"half_a\"}, "
                                 "\"out\": {\"filtered\": \"visibility\"}}"}),
              "nodes.filter1: writes \"visibility\" for each of \"lights\", and others write it, too");
    EXPECT_EQ(error(pipeline(), {"nodes.trace_a={\"type\": \"guides\", \"out\": {\"view_depth\": \"x\", "
                                 "\"guide_normal\": \"y\"}}"}),
              "nodes.trace_a: stands for \"trace_a\", which is another's name");
    EXPECT_EQ(error(pipeline("", R"("a": {"of": "lights"}, "c": {"of": "others"})"),
                    {R"(nodes.other={"type": "filter", "instances": "others", "in": {"signal": "half"}, )"
                     R"("out": {"filtered": "mixed"}})"}),
              "nodes.other_c.in.signal: there is one \"half\" for each of \"lights\": \"half_INSTANCE\"");
}

// A host may add members to those that the text has.
TEST_F(Instances, NoTwoHaveOneName) {
    auto parsed = parse_pipeline(pipeline(), "p.json", {}, diagnostics_);
    ASSERT_TRUE(parsed);
    parsed->instances.push_back(parsed->instances.front());
    EXPECT_FALSE(check(*parsed, nodes_, diagnostics_));
    EXPECT_NE(diagnostics_.text().find("instances.a: is another member's name, too"), std::string::npos)
        << diagnostics_.text();
}

// What they stand for is their number times that of the nodes.
TEST_F(Instances, WhatTheyAreWrittenOutIsBounded) {
    std::string members = R"("a": {"of": "lights"})";
    for (int i = 1; i < 20'000; ++i) members += ", \"i" + std::to_string(i) + R"(": {"of": "lights"})";
    EXPECT_EQ(error(pipeline("", members)),
              "instances: stand for 140000 nodes, inputs, resources and outputs: 100000 are the most");
    std::string params = R"("p": 1)";
    for (int i = 1; i < 60; ++i) params += ", \"p" + std::to_string(i) + "\": 1";
    EXPECT_EQ(
        error(R"({"penumbra": 1, "name": "p", "outputs": ["value"], "instances": {)" + members +
              R"(}, "nodes": {"f": {"type": "fill", "instances": "lights", "params": {)" + params + "}}}}"),
        "instances: stand for 1200000 parameters and wires: 1000000 are the most");
}

}  // namespace
}  // namespace penumbra
