// SPDX-License-Identifier: MIT
// JSON text: every value knows its line and column, and nothing malformed gets through.
#include "penumbra/json_text.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace penumbra {
namespace {

Json parse(std::string_view text) {
    Diagnostics diagnostics;
    const std::optional<Json> json = parse_json(text, "x.json", diagnostics);
    EXPECT_TRUE(json) << diagnostics.text();
    return json.value_or(Json{});
}

std::string errors(std::string_view text) {
    Diagnostics diagnostics;
    const std::optional<Json> json = parse_json(text, "x.json", diagnostics);
    EXPECT_EQ(json.has_value(), diagnostics.empty());
    return diagnostics.text();
}

std::string at(const Place& place) {
    return place.file + ":" + std::to_string(place.line) + ":" + std::to_string(place.column);
}

std::string dump(const Json& json) {
    switch (json.kind) {
        case Json::Kind::null:
            return "null";
        case Json::Kind::boolean:
            return json.boolean ? "true" : "false";
        case Json::Kind::integer:
            return std::to_string(json.integer);
        case Json::Kind::real:
            return std::to_string(json.real);
        case Json::Kind::string:
            return '"' + json.string + '"';
        default:
            break;
    }
    std::string text;
    for (const Json& item : json.items) text += (text.empty() ? "" : ",") + dump(item);
    for (const JsonMember& member : json.members)
        text += (text.empty() ? "" : ",") + member.key + ":" + dump(member.value);
    return json.kind == Json::Kind::array ? "[" + text + "]" : "{" + text + "}";
}

TEST(JsonText, ValuesAndKeysKnowTheirPlaces) {
    const Json json =
        parse("{\n  \"a\": [1, -2.5,\n    true, null],\n\t\"b\" : {\"c\": \"x]},\\\"\"}, \"d\": 7}");
    EXPECT_EQ(at(json.place), "x.json:1:1");
    const Json& a = *json.find("a");
    EXPECT_EQ(at(json.members[0].key_place), "x.json:2:3");
    EXPECT_EQ(at(a.place), "x.json:2:8");
    EXPECT_EQ(at(a.items[0].place), "x.json:2:9");
    EXPECT_EQ(at(a.items[1].place), "x.json:2:12");
    EXPECT_EQ(at(a.items[2].place), "x.json:3:5");
    EXPECT_EQ(at(a.items[3].place), "x.json:3:11");
    EXPECT_EQ(at(json.find("b")->find("c")->place), "x.json:4:14");
    EXPECT_EQ(at(json.find("d")->place), "x.json:4:30")
        << "brackets and quotes inside a string are no tokens";
    EXPECT_EQ(json.find("b")->find("c")->string, "x]},\"");
}

TEST(JsonText, ColumnsCountCharactersNotBytes) {
    const Json json = parse("[\"\xc3\xa4\xe2\x82\xac\", 1]");
    EXPECT_EQ(at(json.items[1].place), "x.json:1:8");
}

TEST(JsonText, CarriageReturnsDoNotCountAsLines) {
    const Json json = parse("[\r\n1,\r\n2]");
    EXPECT_EQ(at(json.items[1].place), "x.json:3:1");
}

TEST(JsonText, NumbersKeepTheirKind) {
    const Json json = parse("[3, -3, 3.0, 3e0, 9223372036854775807, 9223372036854775808, -0]");
    const std::vector<Json::Kind> kinds = {Json::Kind::integer, Json::Kind::integer, Json::Kind::real,
                                           Json::Kind::real,    Json::Kind::integer, Json::Kind::real,
                                           Json::Kind::integer};
    for (size_t i = 0; i < kinds.size(); ++i) EXPECT_EQ(json.items[i].kind, kinds[i]) << i;
    EXPECT_EQ(json.items[0].real, 3.0) << "integers are reals too";
    EXPECT_EQ(json.items[5].real, 9223372036854775808.0);
}

TEST(JsonText, DuplicateKeysAreAllReported) {
    EXPECT_EQ(errors("{\"a\": {\"b\": 1, \"b\": 2},\n \"a\": 3}"),
              "x.json:1:16: a: duplicate key \"b\"\nx.json:2:2: duplicate key \"a\"\n");
    EXPECT_EQ(errors("{\"a\": {\"b\": 1}, \"c\": {\"b\": 1}}"), "") << "equal keys of different objects";
    EXPECT_NE(errors("{\"a\": 1, \"\\u0061\": 2}"), "") << "escapes do not make another key";
}

TEST(JsonText, MalformedTextIsReportedAtTheOffendingToken) {
    EXPECT_EQ(errors("{\n  \"a\": tru\n}"),
              "x.json:2:8: syntax error while parsing value - invalid literal\n");
    EXPECT_NE(errors("[1, 2").find("x.json:1:6: syntax error"), std::string::npos) << errors("[1, 2");
    EXPECT_NE(errors("{\"a\" 1}").find("x.json:1:6: "), std::string::npos) << errors("{\"a\" 1}");
    for (const char* text :
         {"[NaN]",    "[Infinity]", "[-Infinity]",   "[1e999]",    "[-1e999]", "[01]",
          "[1.]",     "[.5]",       "[+1]",          "[0x10]",     "[1,]",     "{\"a\":1,}",
          "{a: 1}",   "['a']",      "// c\n[]",      "[/* c */]",  "[] []",    "{\"a\":1}}",
          "[\"\t\"]", "[\"\\x\"]",  "[\"\\ud800\"]", "[\"\xff\"]", "\"",       "[\"",
          "\\",       "]",          "nul",           "[1}",        "{\"a\"}"})
        EXPECT_NE(errors(text), "") << text;
}

TEST(JsonText, WhatTheParserWouldSkipIsReported) {
    EXPECT_EQ(errors("\xef\xbb\xbf{}"),
              "x.json:1:1: the file begins with a byte order mark; save it as plain UTF-8\n");
    EXPECT_EQ(errors(""), "x.json:1:1: the file is empty\n");
    EXPECT_EQ(errors(" \n\t"), "x.json:1:1: the file is empty\n");
    EXPECT_EQ(errors(std::string_view("{}\n\0garbage", 11)), "x.json:2:1: the file holds a NUL byte\n");
    EXPECT_NE(errors(std::string_view("\0", 1)), "");
}

TEST(JsonText, DepthIsBounded) {
    const auto nested = [](size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); };
    EXPECT_EQ(errors(nested(256)), "");
    EXPECT_EQ(errors(nested(257)), "x.json:1:257: nested more than 256 levels deep\n");
    EXPECT_NE(errors(std::string(1'000'000, '[')), "");
    std::string objects;
    for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
    EXPECT_NE(errors(objects), "");
}

// A byte or two of text are some hundred bytes of memory: how many there may be is bounded, and the bound is
// the caller's.
TEST(JsonText, SizeIsBounded) {
    Diagnostics diagnostics;
    EXPECT_TRUE(parse_json("[1,2,3]", "a.json", diagnostics, 8));
    EXPECT_FALSE(parse_json("[1,\n2,3,4]", "a.json", diagnostics, 8));
    EXPECT_EQ(diagnostics.text(),
              "a.json:2:6: the text has more than 8 values, keys and punctuation marks\n");
    std::string large = "[";
    for (size_t i = 0; i < most_json_tokens / 2; ++i) large += "1,";
    Diagnostics default_bound;
    EXPECT_FALSE(parse_json(large + "1]", "a.json", default_bound));
    EXPECT_EQ(default_bound.size(), 1u);
    Diagnostics endless;
    EXPECT_FALSE(read_json("/dev/zero", endless, 1000));
    EXPECT_NE(endless.text().find("has more than 64000 bytes"), std::string::npos) << endless.text();
}

TEST(JsonText, FilesThatCannotBeReadAreDiagnostics) {
    Diagnostics diagnostics;
    EXPECT_FALSE(read_json("no/such/file.json", diagnostics));
    EXPECT_FALSE(read_json(std::filesystem::temp_directory_path(), diagnostics));
    EXPECT_EQ(diagnostics.size(), 2u);
    EXPECT_EQ(to_string(diagnostics.list()[0]), "no/such/file.json: no such file");
}

// The examples of RFC 7396, appendix A.
TEST(JsonText, MergePatchFollowsTheRfc) {
    const char* cases[][3] = {
        {R"({"a":"b"})", R"({"a":"c"})", R"({"a":"c"})"},
        {R"({"a":"b"})", R"({"b":"c"})", R"({"a":"b","b":"c"})"},
        {R"({"a":"b"})", R"({"a":null})", R"({})"},
        {R"({"a":"b","b":"c"})", R"({"a":null})", R"({"b":"c"})"},
        {R"({"a":["b"]})", R"({"a":"c"})", R"({"a":"c"})"},
        {R"({"a":"c"})", R"({"a":["b"]})", R"({"a":["b"]})"},
        {R"({"a":{"b":"c"}})", R"({"a":{"b":"d","c":null}})", R"({"a":{"b":"d"}})"},
        {R"({"a":[{"b":"c"}]})", R"({"a":[1]})", R"({"a":[1]})"},
        {R"(["a","b"])", R"(["c","d"])", R"(["c","d"])"},
        {R"({"a":"b"})", R"(["c"])", R"(["c"])"},
        {R"({"a":"foo"})", R"(null)", R"(null)"},
        {R"({"a":"foo"})", R"("bar")", R"("bar")"},
        {R"({"e":null})", R"({"a":1})", R"({"e":null,"a":1})"},
        {R"([1,2])", R"({"a":"b","c":null})", R"({"a":"b"})"},
        {R"({})", R"({"a":{"bb":{"ccc":null}}})", R"({"a":{"bb":{}}})"},
    };
    for (const auto& [target_text, patch_text, expected] : cases) {
        Json target = parse(target_text);
        merge_patch(target, parse(patch_text));
        EXPECT_EQ(dump(target), dump(parse(expected))) << target_text << " + " << patch_text;
    }
}

TEST(JsonText, MergedValuesKeepTheirOrigin) {
    Diagnostics diagnostics;
    Json target = *parse_json("{\"a\": {\"x\": 1,\n \"y\": 2}}", "base.json", diagnostics);
    merge_patch(target, *parse_json("\n\n{\"a\": {\"y\": 3}, \"b\": {\"c\": 4}}", "patch.json", diagnostics));
    EXPECT_EQ(at(target.find("a")->place), "base.json:1:7");
    EXPECT_EQ(at(target.find("a")->find("x")->place), "base.json:1:13");
    EXPECT_EQ(at(target.find("a")->find("y")->place), "patch.json:3:13");
    EXPECT_EQ(at(target.find("b")->find("c")->place), "patch.json:3:28");
}

TEST(JsonText, SetPathTakesJsonOrElseAString) {
    Json json = parse(R"({"nodes": {"f": {"params": {"step": 1}}}})");
    const Place place{"--set"};
    set_path(json, "nodes.f.params.step", "2", place);
    set_path(json, "nodes.f.params.mode", "tent", place);
    set_path(json, "nodes.g.in.x", "null", place);
    set_path(json, "outputs", R"(["a", "b"])", place);
    set_path(json, "nodes.f.type.deeper", "\"q\"", place);
    set_path(json, "doc", "", place);
    EXPECT_EQ(
        dump(json),
        R"({nodes:{f:{params:{step:2,mode:"tent"},type:{deeper:"q"}},g:{in:{x:null}}},outputs:["a","b"],doc:""})");
    EXPECT_EQ(json.find("nodes")->find("f")->find("params")->find("step")->place.file, "--set");
    EXPECT_EQ(json.find("outputs")->items[1].place.file, "--set");
    EXPECT_EQ(json.find("nodes")->place.file, "x.json");
}

TEST(Diagnostics, AMisspeltNameFindsTheNearest) {
    const std::vector<std::string> names = {"filtered0", "filtered1", "visibility", "depth"};
    EXPECT_EQ(did_you_mean("filterd0", names), "; did you mean \"filtered0\"?");
    EXPECT_EQ(did_you_mean("visibiltiy", names), "; did you mean \"visibility\"?");
    EXPECT_EQ(did_you_mean("dpeth", names), "; did you mean \"depth\"?") << "a transposition is one edit";
    EXPECT_EQ(did_you_mean("mask", names), "");
    EXPECT_EQ(did_you_mean("x", names), "");
    EXPECT_EQ(did_you_mean(std::string(1'000'000, 'd'), names), "");
}

TEST(Diagnostics, StayOneLineWhateverTheNamesHold) {
    EXPECT_EQ(to_string(Diagnostic{Place{"a\nb", 1, 2}, "p", "no \"\x1b[0m\""}),
              "a\\x0ab:1:2: p: no \"\\x1b[0m\"");
    EXPECT_EQ(to_string(Diagnostic{Place{"", 0, 0}, "", "m"}), "m");
    EXPECT_EQ(to_string(Diagnostic{Place{"f", 0, 0}, "p", "m"}), "f: p: m");
}

}  // namespace
}  // namespace penumbra
