// SPDX-License-Identifier: MIT
// check() on valid pipelines, and the rules whose borders matter. Messages are in tests/golden/broken.

#include "tests/check_test.h"

namespace penumbra::test {
namespace {

TEST_F(Check, BindsEveryPortOnce) {
    const auto checked = run(toy_pipeline());
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
    const auto checked = run(toy_pipeline(), {"outputs=[\"color\", \"debug\"]", "nodes.classify.if=alpha",
                                              "nodes.trace.if=alpha"});
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
    std::string undefined, writers, circles, optional, with;
    for (size_t i = 0; i < count; ++i) {
        const std::string comma = i ? "," : "", id = std::to_string(i);
        undefined += comma + "\"f" + id + R"(": {"type": "filter", "in": {"signal": "missing)" + id +
                     R"("}, "out": {"filtered": "mizzing)" + id + "\"}}";
        writers += comma + "\"w" + id + R"(": {"type": "fill"})";
        circles +=
            comma + "\"c" + id + R"(": {"type": "filter", "in": {"signal": "x"}, "out": {"filtered": "x"}})";
        optional += comma + "\"input" + id + R"(": {"optional": true})";
        with += comma + "\"n" + id + R"(": {"type": "fill", "with": "imput)" + id +
                R"(", "out": {"value": "v)" + id + "\"}}";
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
    EXPECT_FALSE(run(pipeline("", R"("x")", circles)));
    EXPECT_EQ(diagnostics_.size(), count) << "and one that waits for itself";
    EXPECT_FALSE(run(pipeline(optional, R"("v0")", with)));
    EXPECT_GE(diagnostics_.size(), count);
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

TEST_F(Check, AHostInputOfAnyExtentKeepsThat) {
    const auto checked =
        run(pipeline(R"("albedo": {"extent": "any"})", R"("lit")", R"("s": {"type": "shade"})"));
    ASSERT_TRUE(checked) << diagnostics_.text();
    EXPECT_EQ(checked->inputs[0].extent, HostInput::Extent::any);
}

}  // namespace
}  // namespace penumbra::test
