// SPDX-License-Identifier: MIT
// check() where nodes, ports or writers are there under some facts or parameters alone.

#include "tests/check_test.h"

namespace penumbra::test {
namespace {

TEST_F(Check, TwoWritersNeedConditionsThatExcludeEachOther) {
    const auto two = [](const std::string& a, const std::string& b) {
        return pipeline("", R"("value")",
                        R"("a": {"type": "fill")" + a + R"(}, "b": {"type": "fill")" + b + "}");
    };
    expect_valid(two(R"(, "if": "sun_up")", R"(, "if": "!sun_up")"));
    EXPECT_NE(error(two(R"(, "if": "sun_up")", "")), "");
    EXPECT_NE(error(two("", "")), "");
    EXPECT_EQ(error(two(R"(, "if": "sun_up & alpha")", R"(, "if": "!sun_up")")),
              "outputs[0]: nobody writes \"value\" where !alpha & sun_up");
    expect_valid(
        pipeline("", R"("value")",
                 R"("a": {"type": "fill", "if": "sun_up & alpha"}, "b": {"type": "fill", "if": "!sun_up"},
        "c": {"type": "fill", "if": "sun_up & !alpha"})"));
}

TEST_F(Check, AMissingWriterUnderSomeFactsIsAnErrorUnlessTheReaderIsOptionalOrGoneToo) {
    const auto reader = [](const std::string& port_text) {
        return pipeline(R"("albedo": {})", R"("lit")",
                        R"("f": {"type": "fill", "if": "sun_up", "out": {"value": "v"}}, )" + port_text);
    };
    expect_valid(reader(R"("s": {"type": "shade", "in": {"visibility": "v"}})"));
    const std::string filter = R"("g": {"type": "filter", "in": {"signal": "w"}, "out": {"filtered": "x"}%})";
    const auto filtered = [&](const std::string& condition) {
        std::string text = filter;
        text.replace(text.find('%'), 1, condition);
        return pipeline("", R"("y")",
                        R"("y": {"type": "fill", "out": {"value": "y"}},
            "f": {"type": "fill", "if": "sun_up & alpha", "out": {"value": "w"}}, )" +
                            text);
    };
    EXPECT_EQ(error(filtered("")),
              "nodes.g.in.signal: nobody writes \"w\" where !alpha, and the port is not optional");
    EXPECT_EQ(error(filtered(R"(, "if": "alpha")")),
              "nodes.g.in.signal: nobody writes \"w\" where alpha & !sun_up, and the port is not optional");
    expect_valid(filtered(R"(, "if": "alpha & sun_up & hdr")"));
}

TEST_F(Check, HistoryOfAWriterThatIsGoneUnderSomeFactsNeedsAnOptionalPort) {
    const std::string taa = R"("a": {"type": "taa", "if": "moves", "in": {"history": "color@-1"}},
        "b": {"type": "taa", "in": {"history": "color@-1"}, "out": {"color": "other"}})";
    EXPECT_EQ(error(pipeline(R"("lit": {})", R"("other")", taa)),
              "nodes.b.in.history: nobody writes \"color\" where !moves, and the port is not optional");
    expect_valid(
        toy_pipeline());  // denoise.history reads half@-1, which casters decides, together with denoise
}

TEST_F(Check, ACycleMayExistUnderConditionsThatExcludeEachOther) {
    const auto ring = [](const std::string& first, const std::string& second) {
        return pipeline(
            "", R"("x")",
            R"("a": {"type": "filter", "in": {"signal": "y"}, "out": {"filtered": "x"}, "if": ")" + first +
                R"("}, "b": {"type": "filter", "in": {"signal": "x"}, "out": {"filtered": "y"}, "if": ")" +
                second + R"("},
            "fx": {"type": "fill", "out": {"value": "x"}, "if": "!sun_up"}, "fy": {"type": "fill", "out": {"value": "y"}, "if": "sun_up"})");
    };
    expect_valid(ring("sun_up", "!sun_up"));  // x from y where sun_up, y from x where not
    const std::string both =
        pipeline("", R"("x")", R"("a": {"type": "filter", "in": {"signal": "y"}, "out": {"filtered": "x"}},
        "b": {"type": "filter", "in": {"signal": "x"}, "out": {"filtered": "y"}})");
    EXPECT_EQ(error(both), "nodes.a.in.signal: nodes wait for each other within one frame: a -> b -> a");
    EXPECT_EQ(error(pipeline("", R"("x")",
                             R"("a": {"type": "filter", "in": {"signal": "x"}, "out": {"filtered": "x"}})")),
              "nodes.a.in.signal: nodes wait for each other within one frame: a -> a");
}

TEST_F(Check, APortThatItsNodesParametersRuleOutNeedsNoResource) {
    const std::string nodes =
        R"("g": {"type": "guides"}, "c": {"type": "classify", "params": {"mode": "%"}})";
    const auto with = [&](const std::string& mode, const std::string& more) {
        std::string text = nodes + more;
        text.replace(text.find('%'), 1, mode);
        return pipeline(R"("depth": {}, "normal": {}, "sun": {}, "cascade_maps": {})", R"("hits")", text);
    };
    expect_valid(with("normals", ""));
    EXPECT_EQ(error(with("cascades", "")),
              "nodes.c.in.bounds: no resource named \"bounds\" (the port's own name)");
    expect_valid(with("cascades", R"(, "p": {"type": "pyramid"})"));
}

TEST_F(Check, APortThatAFactRulesOutNeedsNoWriterThen) {
    const auto with = [](const std::string& condition) {
        return pipeline(R"("lit": {})", R"("tinted")",
                        R"("t": {"type": "tint"}, "f": {"type": "fill", "out": {"value": "mask"}, "if": ")" +
                            condition + "\"}");
    };
    expect_valid(with("alpha"));
    EXPECT_EQ(error(with("alpha & hdr")),
              "nodes.t.in.mask: nobody writes \"mask\" where alpha & !hdr, and the port is not optional");
    expect_valid(pipeline(R"("lit": {})", R"("tinted")",
                          R"("t": {"type": "tint", "if": "!alpha"}, "l": {"type": "tint", "if": "alpha",
        "in": {"mask": "m"}}, "m": {"type": "fill", "out": {"value": "m"}})"));
}

// A filter behind two fills, one of which runs by the filter's step.
std::string chosen_by(const std::string& first, const std::string& second, const std::string& params = "") {
    return pipeline("", R"("filtered")",
                    R"("a": {"type": "fill", "out": {"value": "v"}, "if": ")" + first +
                        R"("}, "b": {"type": "fill", "out": {"value": "v"}, "if": ")" + second +
                        R"("}, "f": {"type": "filter", "in": {"signal": "v"})" + params + "}");
}

TEST_F(Check, AComparisonAsksForTheValueThatThePipelineEndsUpWith) {
    const auto runs = [&](const std::string& text, const std::vector<std::string>& settings) {
        const auto checked = run(text, settings);
        EXPECT_TRUE(checked) << diagnostics_.text();
        std::string ids;
        for (const BoundNode& node : checked ? checked->nodes : std::vector<BoundNode>()) {
            EXPECT_TRUE(node.cases.all() || node.cases.none()) << node.id;
            if (node.cases.all()) ids += node.id;
        }
        return ids;
    };
    const std::string two = chosen_by("f.step<4", "f.step>=4");  // f stands further down
    EXPECT_EQ(runs(two, {}), "af") << "the default, 1";
    EXPECT_EQ(runs(two, {"nodes.f.params.step=4"}), "bf");
    EXPECT_EQ(runs(chosen_by("f.step<4", "f.step>=4", R"(, "params": {"step": 8})"), {}), "bf");
    EXPECT_EQ(
        runs(chosen_by("f.step<4", "f.step>=4", R"(, "params": {"step": 8})"), {"nodes.f.params.step=3"}),
        "af");
    EXPECT_EQ(runs(two, {"nodes.f.if=!f.step=1 | f.step=1"}), "af");
    EXPECT_EQ(error(chosen_by("f.step<4", "f.step>4"), {"nodes.f.params.step=4"}),
              "nodes.f.in.signal: nobody writes \"v\" with these parameters, and the port is not optional");
    EXPECT_EQ(error(chosen_by("f.step<=4", "f.step>=4"), {"nodes.f.params.step=4"}),
              "nodes.b.out.value: \"v\" is also written by nodes.a.out.value; two writers of one name need "
              "conditions "
              "(\"if\") that exclude each other");
}

// "auto" is settled once the device is known, which is after who runs.
TEST_F(Check, ABackendThatTheDeviceChoosesDecidesNothing) {
    nodes_.add({.type = parse_toy(R"({"node": "looks", "doc": "d", "shader": "l.comp",
        "inputs": {"scene": {"kind": "scene"}}, "outputs": {"seen": {"kind": "image", "format": "r16f"}},
        "params": {"backend": {"type": "enum", "values": ["auto", "bvh", "ray_query"], "default": "auto",
                               "constant": true, "doc": "d"}}, "dispatch": {"over": "frame"}})",
                                  "looks")});
    const auto with = [](const std::string& params) {
        return pipeline(
            R"("scene": {})", R"("seen")",
            R"("l": {"type": "looks")" + params + R"(}, "a": {"type": "fill", "if": "l.backend=bvh"})");
    };
    expect_valid(with(R"(, "params": {"backend": "ray_query"})"));
    for (const char* params : {"", R"(, "params": {"backend": "auto"})"})
        EXPECT_EQ(error(with(params)),
                  "nodes.a.if: \"l.backend\" depends on the device where it is \"auto\"");
}

TEST_F(Check, ComparisonsAndFactsMix) {
    // In how many 512ths of all cases of facts the node runs: each fact that decides halves them.
    const auto cases = [&](const std::string& condition) {
        const std::string nodes =
            R"("n": {"type": "fill", "out": {"value": "maybe"}, "if": ")" + condition + R"("},
            "f": {"type": "fill", "params": {"weight": 0.1, "flat": true}},
            "s": {"type": "filter", "in": {"signal": "value"}, "params": {"step": 4}},
            "g": {"type": "guides"}, "c": {"type": "classify"})";
        const auto checked = run(pipeline(R"("sun": {}, "depth": {}, "normal": {})", R"("filtered")", nodes));
        const FactCases runs = checked ? checked->nodes[0].cases : FactCases();
        return checked ? static_cast<int>(runs.count() * 512 / runs.size()) : -1;
    };
    EXPECT_EQ(cases("s.step=4"), 512);
    EXPECT_EQ(cases(" s.step >= 4 & sun_up "), 256);
    EXPECT_EQ(cases("s.step>4 & sun_up"), 0);
    EXPECT_EQ(cases("s.step>4 | sun_up"), 256);
    EXPECT_EQ(cases("s.step<=4 | sun_up"), 512);
    EXPECT_EQ(cases("sun_up & !alpha | s.step!=4 & hdr | !sun_up"), 384) << "& binds before |";
    EXPECT_EQ(cases("sun_up | !sun_up"), 512);
    EXPECT_EQ(cases("! s.step<4 & !s.step=3 & s.step < 16"), 512);
    EXPECT_EQ(cases("f.flat & !s.step!=4"), 512);
    EXPECT_EQ(cases("!f.flat"), 0);
    EXPECT_EQ(cases("f.flat=true & f.flat!=false"), 512);
    EXPECT_EQ(cases("n.flat"), 0) << "a node may ask for its own";
    EXPECT_EQ(cases("f.weight=0.1 & f.weight>=0.1 & f.weight<=1e-1"), 512)
        << "0.1 is the same float on both sides";
    EXPECT_EQ(cases("f.weight<0.1 | f.weight>0.1"), 0);
    EXPECT_EQ(cases("c.mode=normals & !c.mode=cascades & c.mode!=cascades"), 512);
}

TEST_F(Check, WhatRunsUnderNoFactsIsCheckedAndInNobodysWay) {
    const auto with = [](const std::string& wire, const std::string& more = "") {
        return pipeline(
            "", R"("s2")",
            std::string(sum_nodes) + R"(, "r": {"type": "accumulate", "if": "f.flat", )" + wire + "}" + more);
    };
    expect_valid(with(R"("in": {"sum": "s0"}, "out": {"total": "s1"})"));  // s1 has two writers, s0 two
                                                                           // updaters, once it runs
    EXPECT_FALSE(run(with(R"("in": {"sum": "s0"}, "out": {"total": "s1"})"), {"nodes.f.params.flat=true"}));
    expect_valid(
        with(R"("in": {"sum": "s2"}, "out": {"total": "s3"})"));  // s2 would not last to the end of the frame
    EXPECT_FALSE(run(with(R"("in": {"sum": "s2"}, "out": {"total": "s3"})"), {"nodes.f.params.flat=true"}));
    EXPECT_EQ(error(with(R"("in": {"sum": "s9"}, "out": {"total": "s3"})")),
              "nodes.r.in.sum: no resource named \"s9\"; did you mean \"s0\"?");
    EXPECT_NE(error(with(R"("in": {"sun": "s0"}, "out": {"total": "s3"})")), "");
}

}  // namespace
}  // namespace penumbra::test
