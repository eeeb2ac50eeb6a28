// SPDX-License-Identifier: MIT
// Broken inputs and exactly what is said about them: tests/golden/broken/NAME.json (pipelines, against the
// toy nodes) and NAME.node.json (declarations) with NAME.txt; NAME.set has settings, one a line; *.part.json
// is only extended. PENUMBRA_REWRITE_GOLDEN=1 rewrites the expectations. Then: no truncated or altered input
// may crash anything.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

#include "penumbra/check.h"
#include "tests/golden_text.h"
#include "tests/toy_nodes.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

const fs::path folder = "tests/golden/broken";

// Pipelines and declarations, but not what is only extended.
std::vector<std::string> broken_names() {
    std::vector<std::string> names = test::names_in(folder, ".json");
    std::erase_if(names, [](const std::string& name) { return name.ends_with(".part"); });
    return names;
}

void try_pipeline(const std::optional<Pipeline>& pipeline, const NodeSet& nodes, Diagnostics& diagnostics) {
    if (pipeline) check(*pipeline, nodes, diagnostics);
}

class BrokenInput : public test::InSourceRoot {};

TEST_P(BrokenInput, IsExplained) {
    const std::string name = GetParam();
    const fs::path file = folder / (name + ".json");
    Diagnostics diagnostics;
    if (name.ends_with(".node")) {
        const auto json = read_json(file, diagnostics);
        if (json) parse_node_type(*json, name.substr(0, name.size() - 5), test::toy_domain(), diagnostics);
    } else {
        std::vector<std::string> settings;
        std::ifstream stream(folder / (name + ".set"));
        for (std::string line; std::getline(stream, line);) settings.push_back(line);
        const NodeSet nodes = test::toy_nodes();
        try_pipeline(load_pipeline(file, settings, diagnostics), nodes, diagnostics);
    }
    ASSERT_FALSE(diagnostics.empty()) << file << " is not broken";
    test::expect_golden(diagnostics.text(), folder / (name.substr(0, name.find('.')) + ".txt"));
}

INSTANTIATE_TEST_SUITE_P(Golden, BrokenInput, ::testing::ValuesIn(broken_names()), [](const auto& instance) {
    std::string name = instance.param;
    std::ranges::replace(name, '.', '_');
    return name;
});

// Every place must lie in the text that was read: an editor jumps there.
void expect_places_inside(const Diagnostics& diagnostics, const std::string& text) {
    const auto lines = 1 + std::ranges::count(text, '\n');
    for (const Diagnostic& diagnostic : diagnostics.list()) {
        EXPECT_GE(diagnostic.place.line, 1) << to_string(diagnostic);
        EXPECT_LE(diagnostic.place.line, lines) << to_string(diagnostic);
        EXPECT_FALSE(diagnostic.message.empty());
    }
}

void survive_pipeline(const std::string& text, const NodeSet& nodes) {
    Diagnostics diagnostics;
    const auto pipeline = parse_pipeline(text, "p.json", {}, diagnostics);
    EXPECT_EQ(pipeline.has_value(), diagnostics.empty());
    try_pipeline(pipeline, nodes, diagnostics);
    expect_places_inside(diagnostics, text);
}

void survive_declaration(const std::string& text, const std::string& name) {
    Diagnostics diagnostics;
    if (const auto json = parse_json(text, "n.json", diagnostics)) {
        const auto type = parse_node_type(*json, name, test::toy_domain(), diagnostics);
        EXPECT_EQ(type.has_value(), diagnostics.empty());
    }
    expect_places_inside(diagnostics, text);
}

// Alters text by bytes that matter to JSON and by pieces of itself, which keeps more of it well-formed than
// noise does.
std::string altered(std::string text, std::mt19937& random) {
    const auto below = [&](size_t n) { return static_cast<size_t>(random() % n); };
    const std::string bytes = std::string("{}[]\",:0-19.eE\\@ \n&|!=<>_azAZ\x80\xff") + '\0';
    for (size_t edits = 1 + below(3); edits > 0 && !text.empty(); --edits) {
        const size_t at = below(text.size());
        switch (below(5)) {
            case 0:
                text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
                break;
            case 1:
                text[at] = bytes[below(bytes.size())];
                break;
            case 2:
                text.erase(at, 1 + below(12));
                break;
            case 3:
                text.insert(at, text.substr(below(text.size()), 1 + below(24)));
                break;
            default:
                text.insert(at, 1, bytes[below(bytes.size())]);
                break;
        }
    }
    return text;
}

// Swaps two quoted strings: stays JSON, so that the later phases see it.
std::string with_swapped_strings(const std::string& text, std::mt19937& random) {
    std::vector<std::pair<size_t, size_t>> strings;  // begin, end of the text between quotes
    for (size_t begin = text.find('"'); begin != std::string::npos;) {
        const size_t end = text.find('"', begin + 1);
        strings.emplace_back(begin + 1, end);
        begin = text.find('"', end + 1);
    }
    const auto [to, to_end] = strings[random() % strings.size()];
    const auto [from, from_end] = strings[random() % strings.size()];
    std::string result = text;
    return result.replace(to, to_end - to, text.substr(from, from_end - from));
}

TEST(AnyInput, TruncatedNeverCrashes) {
    const NodeSet nodes = test::toy_nodes();
    const std::string pipeline = test::toy_pipeline();
    for (size_t length = 0; length < pipeline.size(); ++length)
        survive_pipeline(pipeline.substr(0, length), nodes);
    const std::string declaration = test::toy_declaration("classify");
    for (size_t length = 0; length < declaration.size(); ++length)
        survive_declaration(declaration.substr(0, length), "classify");
}

TEST(AnyInput, AlteredNeverCrashes) {
    const NodeSet nodes = test::toy_nodes();
    std::mt19937 random(1);
    for (int i = 0; i < 1500; ++i) {
        survive_pipeline(altered(test::toy_pipeline(), random), nodes);
        survive_pipeline(with_swapped_strings(test::toy_pipeline(), random), nodes);
        for (const char* name : {"classify", "trace", "denoise"}) {
            survive_declaration(altered(test::toy_declaration(name), random), name);
            survive_declaration(with_swapped_strings(test::toy_declaration(name), random), name);
        }
    }
}

}  // namespace
}  // namespace penumbra
