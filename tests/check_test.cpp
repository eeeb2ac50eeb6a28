// SPDX-License-Identifier: MIT
// check() on valid pipelines, and the rules whose borders matter. Messages are in tests/golden/broken.
#include "penumbra/check.h"

#include <gtest/gtest.h>

#include "tests/toy_nodes.h"

namespace penumbra {
namespace {

// A pipeline of these inputs, outputs and nodes ("more" may add keys).
std::string pipeline(const std::string& inputs, const std::string& outputs, const std::string& nodes,
                     const std::string& more = "") {
    return R"({"penumbra": 1, "name": "p", "inputs": {)" + inputs + R"(}, "outputs": [)" + outputs +
           R"(], "nodes": {)" + nodes + "}" + more + "}";
}

class Check : public ::testing::Test {
  protected:
    std::optional<CheckedPipeline> run(const std::string& text,
                                       const std::vector<std::string>& settings = {}) {
        diagnostics_ = {};
        const auto parsed = parse_pipeline(text, "p.json", settings, diagnostics_);
        EXPECT_TRUE(parsed) << diagnostics_.text();
        if (!parsed) return std::nullopt;
        const auto checked = check(*parsed, nodes_, diagnostics_);
        EXPECT_EQ(checked.has_value(), diagnostics_.empty());
        return checked;
    }
    // The one error's message, or all the text where there is not exactly one.
    std::string error(const std::string& text, const std::vector<std::string>& settings = {}) {
        EXPECT_FALSE(run(text, settings)) << text;
        if (diagnostics_.size() != 1) return diagnostics_.text();
        return diagnostics_.list()[0].path + ": " + diagnostics_.list()[0].message;
    }
    void expect_valid(const std::string& text) { EXPECT_TRUE(run(text)) << diagnostics_.text(); }

    static const BoundPort& port(const CheckedPipeline& checked, const std::string& node,
                                 const std::string& name) {
        for (const BoundNode& bound : checked.nodes)
            if (bound.id == node)
                for (const BoundPort& p : bound.ports)
                    if (p.port->name == name) return p;
        throw std::runtime_error("no port " + node + "." + name);
    }

    static size_t param_index(const CheckedPipeline& checked, size_t node, const std::string& name) {
        const NodeType& type = checked.nodes[node].type();
        return static_cast<size_t>(type.param(name) - type.params.data());
    }
    static const ParamValue& param(const CheckedPipeline& checked, size_t node, const std::string& name) {
        return checked.nodes[node].params[param_index(checked, node, name)];
    }
    static bool is_set(const CheckedPipeline& checked, size_t node, const std::string& name) {
        return checked.nodes[node].set[param_index(checked, node, name)];
    }
    // The name that a port reads or writes; empty: unbound.
    static std::string bound_to(const CheckedPipeline& checked, const std::string& node,
                                const std::string& name) {
        const BoundPort& bound = port(checked, node, name);
        return bound.resource == no_resource ? "" : checked.resources[bound.resource].name;
    }

    NodeSet nodes_ = test::toy_nodes();
    Diagnostics diagnostics_;
};

TEST_F(Check, BindsEveryPortOnce) {
    const auto checked = run(test::toy_pipeline());
    ASSERT_TRUE(checked) << diagnostics_.text();
    for (const BoundNode& node : checked->nodes) {
        ASSERT_EQ(node.ports.size(), node.type().ports.size());
        for (size_t i = 0; i < node.ports.size(); ++i) EXPECT_EQ(node.ports[i].port, &node.type().ports[i]);
    }
    EXPECT_EQ(bound_to(*checked, "denoise", "words"), "traced");
    EXPECT_EQ(bound_to(*checked, "denoise", "history"), "half");
    EXPECT_TRUE(port(*checked, "denoise", "history").previous);
    EXPECT_EQ(bound_to(*checked, "denoise", "motion"), "motion")
        << "an optional port takes a host input of its name";
    EXPECT_EQ(bound_to(*checked, "classify", "bounds"), "") << "its condition mode=cascades does not hold";
    EXPECT_EQ(bound_to(*checked, "classify", "debug"), "") << "nobody asks for this optional output";
    EXPECT_EQ(checked->inputs[0].kind, PortKind::image);
    EXPECT_EQ(checked->inputs[5].kind, PortKind::bundle);
    EXPECT_EQ(std::get<int32_t>(param(*checked, 5, "step")), 2);
    EXPECT_TRUE(is_set(*checked, 5, "step"));
    EXPECT_FALSE(is_set(*checked, 5, "strength"));
    EXPECT_EQ(std::get<float>(param(*checked, 5, "strength")), 1.0f);
}

TEST_F(Check, AnOptionalOutputExistsWhereSomebodyAsksForIt) {
    const auto checked = run(test::toy_pipeline(), {"outputs=[\"color\", \"debug\"]",
                                                    "nodes.classify.if=alpha", "nodes.trace.if=alpha"});
    EXPECT_FALSE(checked) << "an output must be written under all facts";
    const std::string inputs = R"("depth": {}, "normal": {}, "sun": {})";
    const std::string classify = R"("guides": {"type": "guides"}, "classify": {"type": "classify"%})";
    const auto with = [&](const std::string& out) {
        std::string nodes = classify;
        nodes.replace(nodes.find('%'), 1, out);
        return run(pipeline(inputs, out.empty() ? R"("debug")" : R"("hits")", nodes));
    };
    EXPECT_EQ(bound_to(*with(""), "classify", "debug"), "debug");
    EXPECT_EQ(bound_to(*with(R"(, "out": {"debug": "view"})"), "classify", "debug"), "view");
    EXPECT_EQ(bound_to(*with(R"(, "out": {"debug": null})"), "classify", "debug"), "");
}

TEST_F(Check, AnOptionalInputIsUnboundWhereItsNameDoesNotExist) {
    const auto checked = run(pipeline(R"("albedo": {})", R"("lit")", R"("s": {"type": "shade"})"));
    ASSERT_TRUE(checked) << diagnostics_.text();
    EXPECT_EQ(bound_to(*checked, "s", "visibility"), "");
    EXPECT_NE(error(pipeline(R"("albedo": {})", R"("lit")",
                             R"("s": {"type": "shade", "in": {"visibility": "nowhere"}})")),
              "")
        << "a name that is written out must exist, optional or not";
}

// Ten thousand mistakes at once: each is said once, and the work for suggestions, which compares every wrong
// name with every right one, ends before that.
TEST_F(Check, ManyMistakesAreSaidOnceEach) {
    constexpr size_t count = 10'000;
    std::string undefined, writers;
    for (size_t i = 0; i < count; ++i) {
        const std::string comma = i ? "," : "", id = std::to_string(i);
        undefined += comma + "\"f" + id + R"(": {"type": "filter", "in": {"signal": "missing)" + id +
                     R"("}, "out": {"filtered": "mizzing)" + id + "\"}}";
        writers += comma + "\"w" + id + R"(": {"type": "fill"})";
    }
    EXPECT_FALSE(run(pipeline("", R"("mizzing0")", undefined)));
    EXPECT_EQ(diagnostics_.size(), count);
    size_t suggested = 0;
    for (const Diagnostic& d : diagnostics_.list())
        suggested += d.message.find("did you mean") != std::string::npos;
    EXPECT_GE(suggested, 10u);
    EXPECT_LT(suggested, count / 10);
    EXPECT_FALSE(run(pipeline("", R"("value")", writers)));
    EXPECT_EQ(diagnostics_.size(), count - 1) << "each second writer, not each pair";
}

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

TEST_F(Check, HistoryMayBeReadBeforeAndAfterTheWriter) {
    const std::string inputs = R"("lit": {})";
    expect_valid(pipeline(inputs, R"("color")", R"("taa": {"type": "taa", "in": {"history": "color@-1"}})"));
    expect_valid(pipeline(inputs, R"("late")", R"("taa": {"type": "taa", "in": {"history": "color@-1"}},
        "later": {"type": "taa", "in": {"lit": "color", "history": "color@-1"}, "out": {"color": "late"}})"));
    EXPECT_NE(error(pipeline(inputs, R"("color")", R"("taa": {"type": "taa", "in": {"history": "color"}})")),
              "");
    EXPECT_NE(error(pipeline(inputs, R"("color")", R"("taa": {"type": "taa"})")), "")
        << "no default for a previous port";
    expect_valid(pipeline(R"("lit": {}, "old": {"history": "host"})", R"("color")",
                          R"("taa": {"type": "taa", "in": {"history": "old@-1"}})"));
    EXPECT_NE(error(pipeline(R"("lit": {}, "old": {})", R"("color")",
                             R"("taa": {"type": "taa", "in": {"history": "old@-1"}})")),
              "");
}

TEST_F(Check, HistoryOfAWriterThatIsGoneUnderSomeFactsNeedsAnOptionalPort) {
    const std::string taa = R"("a": {"type": "taa", "if": "moves", "in": {"history": "color@-1"}},
        "b": {"type": "taa", "in": {"history": "color@-1"}, "out": {"color": "other"}})";
    EXPECT_EQ(error(pipeline(R"("lit": {})", R"("other")", taa)),
              "nodes.b.in.history: nobody writes \"color\" where !moves, and the port is not optional");
    expect_valid(
        test::toy_pipeline());  // denoise.history reads half@-1, which casters decides, together with denoise
}

const char* const sum_nodes = R"("f": {"type": "fill", "out": {"value": "s0"}},
    "a": {"type": "accumulate", "in": {"sum": "s0"}, "out": {"total": "s1"}},
    "b": {"type": "accumulate", "in": {"sum": "s1"}, "out": {"total": "s2"}})";

TEST_F(Check, UpdatesFormAChainWithOneEnd) {
    const std::string nodes = sum_nodes;
    expect_valid(pipeline("", R"("s2")", nodes));
    expect_valid(
        pipeline("", R"("s2", "r")",
                 nodes + R"(, "r": {"type": "filter", "in": {"signal": "s0"}, "out": {"filtered": "r"}})"));
    EXPECT_NE(error(pipeline("", R"("s2", "s0")", nodes)), "") << "s0 is overwritten before the frame ends";
    EXPECT_NE(error(pipeline(
                  "", R"("s2")",
                  nodes + R"(, "c": {"type": "accumulate", "in": {"sum": "s0"}, "out": {"total": "s3"}})")),
              "")
        << "two updaters";
    expect_valid(pipeline("", R"("s2")", R"("f": {"type": "fill", "out": {"value": "s0"}},
        "a": {"type": "accumulate", "in": {"sum": "s0"}, "out": {"total": "s2"}, "if": "hdr"},
        "b": {"type": "accumulate", "in": {"sum": "s0"}, "out": {"total": "s2"}, "if": "!hdr"})"));
    EXPECT_NE(error(pipeline(R"("h": {})", R"("s")",
                             R"("a": {"type": "accumulate", "in": {"sum": "h"}, "out": {"total": "s"}})")),
              "");
    EXPECT_NE(error(pipeline("", R"("s")", R"("f": {"type": "fill", "out": {"value": "v"}},
        "a": {"type": "accumulate", "in": {"sum": "v@-1"}, "out": {"total": "s"}})")),
              "");
}

TEST_F(Check, OnlyTheLastNameOfAChainHasHistory) {
    const auto reader = [](const std::string& name, const std::string& condition) {
        return pipeline("", R"("s2", "r")",
                        std::string(sum_nodes) + R"(, "r": {"type": "filter", "in": {"signal": ")" + name +
                            R"("}, "out": {"filtered": "r"}})" + condition);
    };
    expect_valid(reader("s2@-1", ""));
    EXPECT_EQ(error(reader("s0@-1", "")),
              "nodes.r.in.signal: \"s0\" does not last to the next frame: nodes.a.out.total updates it to "
              "\"s1\"; read \"s2@-1\"");
    EXPECT_NE(error(reader("s1@-1", "")), "");
}

TEST_F(Check, ReadersOfAnOldNameComeBeforeItsUpdater) {
    expect_valid(pipeline("", R"("s1")", R"("f": {"type": "fill", "out": {"value": "s0"}},
        "r": {"type": "filter", "in": {"signal": "s0"}, "out": {"filtered": "x"}},
        "a": {"type": "accumulate", "in": {"sum": "s0", "addend": "x"}, "out": {"total": "s1"}})"));
    EXPECT_EQ(error(pipeline("", R"("s2")", R"("f": {"type": "fill", "out": {"value": "s0"}},
        "a": {"type": "accumulate", "in": {"sum": "s0"}, "out": {"total": "s1"}},
        "r": {"type": "accumulate", "in": {"sum": "s1", "addend": "s0"}, "out": {"total": "s2"}})")),
              "nodes.a.out.total: nodes wait for each other within one frame: a -> r -> a")
        << "r reads s1, which a writes, and s0, which a overwrites";
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

TEST_F(Check, FormatsMustMeet) {
    const std::string chain = R"("f": {"type": "filter", "in": {"signal": "s"}, "out": {"filtered": "v"}},
        "s": {"type": "fill", "out": {"value": "s"}}, "g": {"type": "filter", "in": {"signal": "v"}, "out": {"filtered": "w"}})";
    expect_valid(pipeline("", R"("w")", chain));
    expect_valid(pipeline("", R"("w")", chain, R"(, "resources": {"v": {"format": "rg16f"}})"));
    EXPECT_EQ(error(pipeline("", R"("w")", chain, R"(, "resources": {"v": {"format": "r8"}})")),
              "nodes.g.in.signal: \"v\" is r8 (nodes.f.out.filtered), but the port accepts rg16f, r16f");
    EXPECT_NE(error(pipeline("", R"("w")", chain, R"(, "resources": {"v": {"format": "r32f"}})")), "");
    EXPECT_NE(error(pipeline("", R"("s1")", R"("f": {"type": "fill", "out": {"value": "s0"}},
        "a": {"type": "accumulate", "in": {"sum": "s0"}, "out": {"total": "s1"}})",
                             R"(, "resources": {"s0": {"format": "r8"}})")),
              "")
        << "the updated image is r8, which accumulate does not take";
}

TEST_F(Check, ReadersOfAHostInputMustShareAFormat) {
    const std::string probe = R"("p": {"type": "probe", "in": {"image": "h"}})";
    const std::string taa = R"(, "t": {"type": "taa", "in": {"lit": "h", "history": "color@-1"}})";
    const std::string filter = R"(, "f": {"type": "filter", "in": {"signal": "h"}})";
    expect_valid(pipeline(R"("h": {})", R"("report")", probe + filter));
    EXPECT_NE(error(pipeline(R"("h": {})", R"("report")", probe + taa)), "");
    expect_valid(pipeline(R"("h": {"format": "r16f"})", R"("report")", probe + filter));
    EXPECT_NE(error(pipeline(R"("h": {"format": "r32f"})", R"("report")", probe + filter)), "");
    EXPECT_NE(error(pipeline(R"("h": {"kind": "texels"})", R"("report")", probe)), "");
}

TEST_F(Check, AnOptionalHostInputNeedsOptionalPorts) {
    EXPECT_NE(error(pipeline(R"("albedo": {"optional": true})", R"("lit")", R"("s": {"type": "shade"})")),
              "");
    expect_valid(pipeline(R"("albedo": {}, "visibility": {"optional": true})", R"("lit")",
                          R"("s": {"type": "shade"})"));
}

TEST_F(Check, BesideAnotherInputAPortIsNotOptional) {
    nodes_.add({.type = test::parse_toy(R"({ "node": "lit_by", "doc": "d", "shader": "s.comp",
      "inputs": { "place": { "kind": "image", "format": "r16f", "optional": true, "with": ["lamp"] },
                  "lamp": { "kind": "image", "format": "r8", "optional": true } },
      "outputs": { "shown": { "kind": "image", "format": "r8" } },
      "dispatch": { "over": "frame" } })",
                                        "lit_by")});
    const auto with = [](const std::string& inputs, const std::string& in, const std::string& nodes = "") {
        return pipeline(inputs, R"("shown")", nodes + R"("n": {"type": "lit_by", "in": {)" + in + "}}");
    };
    expect_valid(with("", ""));
    expect_valid(with(R"("place": {})", ""));
    expect_valid(with(R"("place": {}, "lamp": {})", ""));
    expect_valid(with(R"("lamp": {})", R"("lamp": null)"));
    EXPECT_EQ(error(with(R"("lamp": {})", "")),
              "nodes.n.in.place: unbound, and beside \"lamp\" the port is not optional");
    EXPECT_EQ(error(with(R"("place": {}, "lamp": {})", R"("place": null)")),
              "nodes.n.in.place: unbound, and beside \"lamp\" the port is not optional");
    EXPECT_EQ(error(with(R"("place": {"optional": true}, "lamp": {})", "")),
              "nodes.n.in.place: the host may leave out \"place\" (\"optional\": true), but the port is not "
              "optional beside \"lamp\"");
    const std::string sometimes = R"("f": {"type": "fill", "if": "sun_up", "out": {"value": "v"}}, )";
    expect_valid(with("", R"("place": "v")", sometimes));
    EXPECT_EQ(
        error(with(R"("lamp": {})", R"("place": "v")", sometimes)),
        "nodes.n.in.place: nobody writes \"v\" where !sun_up, and the port is not optional beside \"lamp\"");
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

TEST_F(Check, AHostInputOfAnyExtentKeepsThat) {
    const auto checked =
        run(pipeline(R"("albedo": {"extent": "any"})", R"("lit")", R"("s": {"type": "shade"})"));
    ASSERT_TRUE(checked) << diagnostics_.text();
    EXPECT_EQ(checked->inputs[0].extent, HostInput::Extent::any);
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
}  // namespace penumbra
