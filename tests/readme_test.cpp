// SPDX-License-Identifier: MIT
// README.md's examples are what it says they are: its pipelines load, its node compiles.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "graph/interface.h"
#include "penumbra/pipeline.h"
#include "penumbra/shadow_nodes.h"
#include "penumbra/user_nodes.h"
#include "tests/test_folder.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

struct Block {
    std::string language, text;
    int line = 0;
};

std::vector<Block> blocks_of(const fs::path& file) {
    std::ifstream stream(file);
    std::vector<Block> blocks;
    bool inside = false;
    int number = 0;
    for (std::string line; std::getline(stream, line);) {
        ++number;
        if (line.starts_with("```")) {
            inside = !inside;
            if (inside) blocks.push_back({line.substr(3), "", number});
        } else if (inside) {
            blocks.back().text += line + "\n";
        }
    }
    EXPECT_FALSE(inside) << "a block does not end";
    return blocks;
}

TEST(Readme, ExamplesWork) {
    const test::TestFolder folder;
    int pipelines = 0, declarations = 0;
    std::string node;  // the declaration that a GLSL block belongs to
    for (const Block& block : blocks_of(fs::path(PENUMBRA_SOURCE_DIR) / "README.md")) {
        SCOPED_TRACE("README.md:" + std::to_string(block.line));
        Diagnostics diagnostics;
        if (block.language == "json") {
            const auto json = parse_json(block.text, "README.md", diagnostics);
            ASSERT_TRUE(json) << diagnostics.text();
            if (const Json* name = json->find("node")) {
                ASSERT_TRUE(parse_node_type(*json, name->string, shadow_domain(), diagnostics))
                    << diagnostics.text();
                node = name->string;
                std::ofstream(folder / (node + ".json")) << block.text;
                ++declarations;
            } else {
                const NodeSet nodes = shadow_nodes();
                const auto pipeline = parse_pipeline(block.text, "README.md", {}, diagnostics);
                EXPECT_TRUE(pipeline && check(*pipeline, nodes, diagnostics)) << diagnostics.text();
                ++pipelines;
            }
        } else if (block.language == "glsl") {
            ASSERT_FALSE(node.empty()) << "no declaration precedes this shader";
            std::ofstream(folder / (node + ".comp")) << block.text;
        } else {
            ADD_FAILURE() << "nothing checks a block of language \"" << block.language << "\"";
        }
    }
    EXPECT_GE(pipelines, 1);
    ASSERT_GE(declarations, 1);
    NodeSet nodes = shadow_nodes();
    Diagnostics diagnostics;
    ASSERT_TRUE(add_user_nodes(nodes, folder, diagnostics, open_shader_cache(""))) << diagnostics.text();
    for (const std::string& name : nodes.names()) {
        const NodeEntry& entry = *nodes.find(name);
        for (const Variant& variant : all_variants(entry.type))
            EXPECT_TRUE(find_shader(entry, variant, diagnostics)) << name << ": " << diagnostics.text();
    }
}

}  // namespace
}  // namespace penumbra
