// SPDX-License-Identifier: MIT
// Declarations and conditions on valid input; what is rejected, and how, is in tests/golden/broken.
#include "penumbra/node_type.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "penumbra/condition.h"
#include "tests/toy_nodes.h"

namespace penumbra {
namespace {

using test::parse_toy;

// A declaration of nothing but parameters, for tests of values.
std::string with_params(const std::string& params) {
    return R"({"node": "n", "doc": "d", "shader": "n.comp", "outputs": {"o": {"kind": "image", "format": "r8"}}, "params": )" +
           params + R"(, "dispatch": {"over": "frame"}})";
}

std::string errors(const std::string& text, const std::string& name = "n") {
    Diagnostics diagnostics;
    const std::optional<Json> json = parse_json(text, name, diagnostics);
    EXPECT_TRUE(json) << diagnostics.text();
    if (!json) return diagnostics.text();
    const auto type = parse_node_type(*json, name, test::toy_domain(), diagnostics);
    EXPECT_EQ(type.has_value(), diagnostics.empty());
    return diagnostics.text();
}

std::optional<Condition> condition(const std::string& text, const NodeType& type) {
    Json json;
    json.kind = Json::Kind::string;
    json.string = text;
    Diagnostics diagnostics;
    auto parsed = parse_condition(json, *type.domain, false, "if", diagnostics);
    const auto find = [&](const Atom& atom) -> KnownParam {
        if (const Param* param = type.param(atom.name))
            return {.param = param, .value = &param->default_value};
        return {.problem = "no such parameter"};
    };
    return parsed && settle(*parsed, find, "if", diagnostics) ? parsed : std::nullopt;
}

TEST(NodeType, PortsKeepTheirOrderAndDefaults) {
    const NodeType type = parse_toy(test::toy_declaration("classify"), "classify");
    ASSERT_EQ(type.ports.size(), 7u);
    EXPECT_EQ(type.ports[0].name, "view_depth");
    EXPECT_TRUE(type.ports[0].storage);
    EXPECT_FALSE(type.ports[2].storage) << "inputs are sampled unless they say otherwise";
    EXPECT_EQ(to_string(type.ports[2].condition), "mode=cascades");
    EXPECT_TRUE(type.port("debug")->storage) << "outputs are storage";
    EXPECT_EQ(type.port("tile_list")->writes, Writes::some);
    EXPECT_EQ(type.port("tile_list")->count.of.name, "frame");
    EXPECT_EQ(type.port("args")->count.of.name, "");
    EXPECT_EQ(type.port("args")->count.add, 4u);
    EXPECT_EQ(type.dispatch.group, (std::array<uint32_t, 3>{8, 4, 1}));
    EXPECT_EQ(type.cpu.group, (std::array<uint32_t, 3>{64, 1, 1}));
    EXPECT_FALSE(type.gpu.group);
    EXPECT_EQ(type.place.file, "classify.json");
    EXPECT_EQ(type.port("sun")->place.line, 5);
}

TEST(NodeType, AnUpdateInheritsWhatItTakesOver) {
    const NodeType type = parse_toy(test::toy_declaration("accumulate"), "accumulate");
    EXPECT_EQ(type.port("total")->formats, type.port("sum")->formats);
    EXPECT_TRUE(type.port("total")->storage);
    EXPECT_EQ(parse_toy(test::toy_declaration("trace"), "trace").port("traced")->element, "u32");
}

TEST(NodeType, ParametersReadTheirOwnType) {
    const NodeType type = parse_toy(with_params(R"({
        "b": {"type": "bool", "default": true, "doc": "d"}, "i": {"type": "int", "default": -2147483648, "doc": "d"},
        "u": {"type": "uint", "default": 4294967295, "doc": "d"}, "f": {"type": "float", "default": 1, "doc": "d"},
        "v": {"type": "vec2", "default": [1, 2.5], "doc": "d", "range": [0, 3]},
        "e": {"type": "enum", "values": ["p", "q"], "default": "q", "doc": "d"}})"),
                                    "n");
    EXPECT_EQ(type.params[0].default_value, ParamValue(true));
    EXPECT_EQ(type.params[1].default_value, ParamValue(std::numeric_limits<int32_t>::min()));
    EXPECT_EQ(type.params[2].default_value, ParamValue(4294967295u));
    EXPECT_EQ(type.params[3].default_value, ParamValue(1.0f));
    EXPECT_EQ(type.params[4].default_value, ParamValue(std::vector<float>{1, 2.5f}));
    EXPECT_EQ(type.params[5].default_value, ParamValue(std::string("q")));
}

TEST(NodeType, ValuesOutsideTypeOrRangeAreErrors) {
    const auto bad = [](const std::string& param) {
        return errors(with_params("{\"p\": {\"doc\": \"d\", " + param + "}}"));
    };
    for (const char* param :
         {R"("type": "int", "default": 2147483648)", R"("type": "uint", "default": -1)",
          R"("type": "int", "default": 1.0)", R"("type": "float", "default": 1e39)",
          R"("type": "float", "default": "1")", R"("type": "bool", "default": 0)",
          R"("type": "vec3", "default": [1, 2])", R"("type": "vec3", "default": 1)",
          R"("type": "vec2", "default": [1, 9], "range": [0, 8])",
          R"("type": "float", "default": 0.5, "range": [1, 2])",
          R"("type": "float", "default": 1, "range": [2, 1])",
          R"("type": "bool", "default": true, "range": [0, 1])",
          R"("type": "enum", "values": [], "default": "a")", R"("type": "enum", "default": "a")",
          R"("type": "enum", "values": ["a"], "default": "b")",
          R"("type": "int", "default": 1, "values": ["a"])",
          R"("type": "vec2", "default": [1, 1], "constant": true)"})
        EXPECT_NE(bad(param), "") << param;
    EXPECT_EQ(bad(R"("type": "float", "default": 0.1, "range": [0.1, 1])"), "")
        << "ranges include their ends";
}

TEST(NodeType, PushConstantsAreCountedWithTheirAlignment) {
    const auto params = [](int vec3s, const std::string& last) {
        std::string text = "{";
        for (int i = 0; i < vec3s; ++i)
            text += "\"v" + std::to_string(i) + R"(": {"type": "vec3", "default": [0, 0, 0], "doc": "d"}, )";
        return with_params(text + last + "}");
    };
    const std::string real = R"("f": {"type": "float", "default": 0, "doc": "d"})";
    const std::string pair = R"("f": {"type": "vec2", "default": [0, 0], "doc": "d"})";
    EXPECT_EQ(errors(params(8, real)), "") << "8 * 16 = 128: the float fills the last vec3's padding";
    EXPECT_NE(errors(params(8, pair)), "") << "8 * 12 + 8 = 104 bytes of data, but they end at 136";
}

TEST(NodeType, ConstantParametersMayHaveNamesThatGlslReserves) {
    const auto step = [](const char* constant) {
        return errors(
            with_params(std::string(R"({"step": {"type": "int", "default": 1, "doc": "d", "constant": )") +
                        constant + "}}"));
    };
    EXPECT_EQ(step("true"), "") << "it becomes STEP";
    EXPECT_NE(step("false"), "");
}

TEST(NodeType, VariantsAreTheProductOfTheStorageFormatLists) {  // at most 16
    const auto outputs = [](const std::string& a, const std::string& b) {
        return errors(
            R"({"node": "n", "doc": "d", "shader": "n.comp", "inputs": {"i": {"kind": "image", "format": ["r8", "r16f", "r32f"]}},
          "outputs": {"a": {"kind": "image", "format": )" +
            a + R"(}, "b": {"kind": "image", "format": )" + b + R"(}}, "dispatch": {"over": "frame"}})");
    };
    EXPECT_EQ(outputs(R"(["r8", "r16f", "r32f", "rg8"])", R"(["r8", "r16f"])"), "")
        << "sampled lists do not count";
    EXPECT_NE(
        outputs(R"(["r8", "r16f", "r32f", "rg8", "rgba8"])", R"(["r8", "r16f", "r32f", "rg8", "rgba8"])"),
        "");
}

// However many a text of some lines asks for, they are counted no further than that they are too many.
TEST(NodeType, MillionsOfVariantsAreRefusedBeforeTheyAreMade) {
    std::string optional = R"("o": {"kind": "image", "format": "r8"})", params, all, any = "p0=0";
    for (int i = 0; i < 26; ++i) {
        const std::string p = "p" + std::to_string(i);
        optional += ", \"o" + p + R"(": {"kind": "image", "format": "r8", "optional": true})";
        params +=
            (i ? ", \"" : "\"") + p + R"(": {"type": "int", "default": 1, "constant": true, "doc": "d"})";
        all += (i ? " & " : "") + p + "=1";
    }
    for (int i = 1; i < 5000; ++i) any += " | p0=" + std::to_string(i % 9);
    const auto with = [&](const std::string& outputs, const std::string& more) {
        return R"({"node": "n", "doc": "d", "outputs": {)" + outputs + "}, \"params\": {" + params + "}, " +
               more + "}";
    };
    const auto when = [](const std::string& condition) {
        return R"("o": {"kind": "image", "format": "r8", "if": ")" + condition + "\"}";
    };
    const std::string shader = R"("shader": "n.comp", "dispatch": {"over": "frame"})";
    EXPECT_EQ(
        errors(with(optional, shader)),
        "n:1:1: formats, optional outputs and backends make more than 1000 shader variants; at most 16 are "
        "allowed\n");
    EXPECT_EQ(errors(with(when(all), shader)),
              "n:1:1: the conditions of outputs tell more than 1000 sets of values apart\n");
    EXPECT_EQ(errors(with(when(any), shader)), "") << "nine values, each of them often";
    EXPECT_EQ(errors(with(optional, R"("host": true)")), "") << "it has no shader";
}

TEST(NodeType, AParameterIsNoFact) {
    const std::string params =
        R"({"alpha": {"type": "bool", "default": true, "constant": true, "doc": "d"}})";
    EXPECT_NE(errors(with_params(params)).find("params.alpha: \"alpha\" is a fact"), std::string::npos);
}

TEST(NodeType, AHostNodeHasNoShaderToCompileForAClass) {
    EXPECT_EQ(errors(R"({"node": "n", "doc": "d", "host": true,
        "outputs": {"v": {"kind": "image", "format": "r8"}}, "classes": {"compiled": true}})"),
              "n:2:86: classes.compiled: a host node has no shader\n");
}

TEST(Condition, HoldsUnderFactsAndConstantParameters) {
    const NodeType type = parse_toy(with_params(R"({
        "mode": {"type": "enum", "values": ["tent", "plane"], "default": "tent", "doc": "d", "constant": true},
        "taps": {"type": "int", "default": 3, "doc": "d", "constant": true},
        "gain": {"type": "float", "default": 1, "doc": "d", "constant": true},
        "fast": {"type": "bool", "default": false, "doc": "d", "constant": true}})"),
                                    "n");
    const auto test = [&](const std::string& text, const std::map<std::string, bool>& facts) {
        const auto parsed = condition(text, type);
        EXPECT_TRUE(parsed) << text;
        if (!parsed) return false;
        size_t given = 0;
        for (size_t i = 0; i < type.domain->facts.size(); ++i) {
            const auto fact = facts.find(type.domain->facts[i].name);
            if (fact == facts.end() || fact->second) given |= size_t{1} << i;
        }
        Diagnostics none;
        const auto find = [&](const Atom& atom) -> KnownParam {
            return {.param = type.param(atom.name), .value = &type.param(atom.name)->default_value};
        };
        return settle(*parsed, find, "if", none)->test(given);
    };
    EXPECT_TRUE(test("sun_up", {})) << "facts default to true";
    EXPECT_FALSE(test("sun_up", {{"sun_up", false}}));
    EXPECT_TRUE(test(" ! sun_up&alpha ", {{"sun_up", false}}));
    EXPECT_TRUE(test("mode=tent & taps=3 & fast=false", {}));
    EXPECT_FALSE(test("mode = plane", {}));
    EXPECT_TRUE(test("!mode=plane & !taps=1", {}));
    EXPECT_FALSE(test("!taps = 3", {}));
    EXPECT_TRUE(test("taps>=3 & !fast | !sun_up", {})) << "the one language, in declarations and pipelines";
    EXPECT_FALSE(test("taps>3 | fast", {}));
    EXPECT_TRUE(test("gain=1 & gain=1.0", {})) << "one value, written in two ways";
    for (const char* text : {"", "&", "sun_up &", "sun", "!mode=tnet", "mode", "mode=tnet", "taps=x",
                             "taps=3.5", "fast=1", "sun_up & !sun_up", "mode=tent & mode=plane",
                             "gain=1 & gain=1.5", "mode=tent & !mode=tent", "mode<tent", "trace.taps=3"})
        EXPECT_FALSE(condition(text, type)) << text;

    std::string joined = "alpha";  // each is compared with all before it
    for (int i = 1; i < 64; ++i) joined += " & taps>=" + std::to_string(i - 64);
    EXPECT_TRUE(condition(joined, type));
    EXPECT_TRUE(condition(joined + " | " + joined, type));
    EXPECT_FALSE(condition(joined + " & fast", type));
}

TEST(NodeSet, ReplacesAType) {
    NodeSet set = test::toy_nodes();
    const auto before = set.share("filter");
    ASSERT_TRUE(before);
    NodeType changed = before->type;
    changed.doc = "changed";
    set.add({.type = changed});
    EXPECT_EQ(set.find("filter")->type.doc, "changed");
    EXPECT_EQ(before->type.doc, "One a-trous pass.") << "whoever shares the old one keeps it";
    EXPECT_FALSE(set.find("filtre"));
    EXPECT_TRUE(std::ranges::is_sorted(set.names()));
}

}  // namespace
}  // namespace penumbra
