// SPDX-License-Identifier: MIT
// Loading pipelines: extends, settings and the places that survive both.
#include "penumbra/pipeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>

#include "tests/test_folder.h"
#include "tests/toy_nodes.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

const char* const base_text = R"({
  "penumbra": 1, "name": "base", "outputs": ["b"],
  "inputs": { "depth": { "history": "host", "extent": [64, 32] } },
  "nodes": {
    "one": { "type": "fill", "out": { "value": "a" }, "params": { "level": 1 } },
    "two": { "type": "filter", "in": { "signal": "a@-1", "meta": null }, "out": { "filtered": "b" }, "if": "sun_up & !alpha" }
  }
})";

class PipelineFiles : public ::testing::Test {
  protected:
    void SetUp() override {
        fs::create_directories(folder_ / "sub");
        write("base.json", base_text);
    }

    void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }

    std::optional<Pipeline> load(const std::string& name, const std::vector<std::string>& settings = {}) {
        return load_pipeline(folder_ / name, settings, diagnostics_);
    }

    // The diagnostics, with the temporary folder's name left out.
    std::string errors() const {
        std::string text = diagnostics_.text();
        const std::string prefix = folder_.string() + "/";
        for (size_t at; (at = text.find(prefix)) != std::string::npos;) text.erase(at, prefix.size());
        return text;
    }

    test::TestFolder folder_;
    Diagnostics diagnostics_;
};

TEST_F(PipelineFiles, AreReadInTheirOwnOrder) {
    const auto pipeline = load("base.json");
    ASSERT_TRUE(pipeline) << errors();
    EXPECT_EQ(pipeline->name, "base");
    ASSERT_EQ(pipeline->nodes.size(), 2u);
    EXPECT_EQ(pipeline->nodes[0].id, "one");
    EXPECT_EQ(pipeline->nodes[0].place.line, 5);
    const PipelineNode& two = pipeline->nodes[1];
    EXPECT_EQ(two.in[0].resource, "a");
    EXPECT_TRUE(two.in[0].previous);
    EXPECT_EQ(two.in[1].resource, "") << "null unbinds";
    ASSERT_TRUE(two.condition);
    EXPECT_EQ(two.condition->string, "sun_up & !alpha");
    EXPECT_TRUE(pipeline->inputs[0].history);
    EXPECT_EQ(pipeline->inputs[0].size, (std::array<uint32_t, 2>{64, 32}));
}

TEST_F(PipelineFiles, AVariantPatchesWhatItExtends) {
    write("sub/variant.json", R"({
  "extends": "../base.json", "name": "variant", "outputs": ["a"],
  "nodes": { "two": null, "one": { "params": { "level": 2 } } }
})");
    write("last.json", R"({ "extends": "sub/variant.json", "nodes": { "three": { "type": "fill" } } })");
    const auto pipeline = load("last.json");
    ASSERT_TRUE(pipeline) << errors();
    EXPECT_EQ(pipeline->name, "variant");
    ASSERT_EQ(pipeline->nodes.size(), 2u);
    EXPECT_EQ(pipeline->nodes[0].id, "one");
    EXPECT_EQ(pipeline->nodes[1].id, "three");
    EXPECT_EQ(pipeline->nodes[0].params[0].value.integer, 2);
    EXPECT_TRUE(pipeline->nodes[0].params[0].value.place.file.ends_with("sub/variant.json"));
    EXPECT_EQ(pipeline->nodes[0].params[0].value.place.line, 3);
    EXPECT_TRUE(pipeline->nodes[0].type_place.file.ends_with("base.json"));
    EXPECT_EQ(pipeline->nodes[0].out[0].resource, "a");
    EXPECT_TRUE(pipeline->file.ends_with("last.json"));
}

// A merge patch takes away what it says null of; of a port that would be its default wire.
TEST_F(PipelineFiles, AVariantUnbindsPorts) {
    write("variant.json", R"({ "extends": "base.json", "nodes": {
  "two": { "in": { "signal": null }, "out": { "filtered": null } },
  "three": { "type": "filter", "in": { "signal": "b", "meta": null } } } })");
    write("last.json", R"({ "extends": "variant.json", "nodes": { "two": { "in": { "signal": "a" } } } })");
    const auto variant = load("variant.json"), last = load("last.json");
    ASSERT_TRUE(variant && last) << errors();
    const auto wire = [](const std::vector<Wire>& wires, const char* port) {
        const auto found = std::ranges::find(wires, port, &Wire::port);
        return found == wires.end() ? "none" : found->resource;
    };
    EXPECT_EQ(wire(variant->nodes[1].in, "signal"), "");
    EXPECT_EQ(wire(variant->nodes[1].out, "filtered"), "");
    EXPECT_EQ(wire(variant->nodes[2].in, "signal"), "b");
    EXPECT_EQ(wire(variant->nodes[2].in, "meta"), "");
    EXPECT_EQ(wire(last->nodes[1].in, "signal"), "a");
    EXPECT_EQ(wire(last->nodes[2].in, "meta"), "");
}

TEST_F(PipelineFiles, ErrorsOfAMergedValueNameTheFileItCameFrom) {
    write("variant.json", "{ \"extends\": \"base.json\",\n  \"nodes\": { \"two\": { \"if\": 7 } } }");
    EXPECT_FALSE(load("variant.json"));
    EXPECT_TRUE(errors().starts_with("variant.json:2:29: nodes.two.if: expected a string, got an integer"))
        << errors();
    write("broken.json", "{ \"penumbra\": 1,\n \"nodes\": 3 }");
    write("variant.json", R"({ "extends": "broken.json", "name": "v", "outputs": ["a"] })");
    diagnostics_ = {};
    EXPECT_FALSE(load("variant.json"));
    EXPECT_EQ(errors(), "broken.json:2:11: nodes: expected an object, got an integer\n");
}

TEST_F(PipelineFiles, ACycleOfExtendsNamesTheChain) {
    write("a.json", R"({ "extends": "sub/b.json" })");
    write("sub/b.json", R"({ "extends": ".././sub/../c.json" })");
    write("c.json", R"({ "extends": "sub/b.json" })");
    EXPECT_FALSE(load("a.json"));
    EXPECT_EQ(
        errors(),
        "c.json:1:14: extends: files extend each other in a cycle: sub/b.json -> c.json -> sub/b.json\n");
    write("self.json", R"({ "extends": "self.json" })");
    diagnostics_ = {};
    EXPECT_FALSE(load("self.json"));
    EXPECT_EQ(errors(),
              "self.json:1:14: extends: files extend each other in a cycle: self.json -> self.json\n");
}

TEST_F(PipelineFiles, ExtendsOfAMissingOrBrokenFileIsAnError) {
    for (const char* extends : {"\"missing.json\"", "\"\"", "3", "\"sub\"", "\"\\u0000\""}) {
        write("v.json", std::string(R"({ "extends": )") + extends + " }");
        diagnostics_ = {};
        EXPECT_FALSE(load("v.json")) << extends;
        EXPECT_EQ(diagnostics_.size(), 1u) << errors();
    }
}

TEST(PipelineText, WhatItExtendsMayBeInMemoryToo) {
    std::map<std::string, std::string> files{
        {"base/all.json", R"({ "penumbra": 1, "name": "all", "outputs": ["a"],
  "nodes": { "one": { "type": "fill", "out": { "value": "a" } } } })"},
        {"loop.json", R"({ "extends": "./base/../loop.json" })"},
        {"broken.json", "{\n3 }"}};
    const ReadFile read = [&](const std::string& file) -> std::optional<std::string> {
        const auto found = files.find(file);
        return found == files.end() ? std::nullopt : std::optional(found->second);
    };
    const auto parsed = [&](const std::string& base, Diagnostics& diagnostics) {
        return parse_pipeline(R"({ "extends": ")" + base + R"(", "name": "mine" })", "sub/mine.json", {},
                              diagnostics, read);
    };
    Diagnostics diagnostics;
    const auto pipeline = parsed("../base/./all.json", diagnostics);
    ASSERT_TRUE(pipeline) << diagnostics.text();
    EXPECT_EQ(pipeline->name, "mine");
    ASSERT_EQ(pipeline->nodes.size(), 1u);
    EXPECT_EQ(pipeline->nodes[0].place.file, "base/all.json");
    for (const auto& [base, error] :
         {std::pair{"none.json", "sub/mine.json:1:14: extends: no file sub/none.json\n"},
          std::pair{"../loop.json",
                    "loop.json:1:14: extends: files extend each other in a cycle: loop.json -> "
                    "loop.json\n"},
          std::pair{"../broken.json", "broken.json:2:1: "}}) {
        Diagnostics errors;
        EXPECT_FALSE(parsed(base, errors));
        EXPECT_TRUE(errors.text().starts_with(error)) << errors.text();
    }
}

TEST_F(PipelineFiles, SettingsApplyAfterExtendsInOrder) {
    write("variant.json", R"({ "extends": "base.json", "nodes": { "one": { "params": { "level": 2 } } } })");
    const auto pipeline = load("variant.json", {"nodes.one.params.level=3", "nodes.one.params.level=4",
                                                "doc=two words", "nodes.two.in.signal=a", "outputs=[\"a\"]"});
    ASSERT_TRUE(pipeline) << errors();
    EXPECT_EQ(pipeline->nodes[0].params[0].value.integer, 4);
    EXPECT_EQ(pipeline->nodes[0].params[0].value.place.file, "--set nodes.one.params.level=4");
    EXPECT_EQ(pipeline->doc, "two words");
    EXPECT_FALSE(pipeline->nodes[1].in[0].previous);
    EXPECT_EQ(pipeline->outputs[0].name, "a");
}

TEST_F(PipelineFiles, ASettingOfNullRemovesANodeAndUnbindsAPort) {
    const auto pipeline =
        load("base.json", {"nodes.two=null", "nodes.one.in={\"x\": \"y\"}", "nodes.one.in.x=null"});
    ASSERT_TRUE(pipeline) << errors();
    ASSERT_EQ(pipeline->nodes.size(), 1u);
    EXPECT_EQ(pipeline->nodes[0].in[0].resource, "");
}

TEST_F(PipelineFiles, BadSettingsAreErrors) {
    for (const char* setting :
         {"nodes.one", "=3", ".a=1", "a.=1", "a..b=1", "", "extends=x.json", "penumbra=2", "colour=red",
          "nodes.oen.params.level=1", "a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a=1"}) {
        diagnostics_ = {};
        EXPECT_FALSE(load("base.json", {setting})) << setting;
        ASSERT_FALSE(diagnostics_.empty());
        EXPECT_EQ(diagnostics_.list()[0].place.file, "--set " + std::string(setting));
    }
    diagnostics_ = {};
    EXPECT_FALSE(load("base.json", {"nodes.oen.params.level=1"}));
    EXPECT_EQ(errors(),
              "--set nodes.oen.params.level=1: nodes.oen: key \"type\" is missing; did you mean \"one\"?\n");
}

TEST(Pipeline, FromTextNeedsNoFile) {
    Diagnostics diagnostics;
    const auto pipeline = parse_pipeline(test::toy_pipeline(), "memory", {}, diagnostics);
    ASSERT_TRUE(pipeline) << diagnostics.text();
    EXPECT_EQ(pipeline->nodes.size(), 9u);
    EXPECT_EQ(pipeline->file, "memory");
}

}  // namespace
}  // namespace penumbra
