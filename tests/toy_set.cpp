// SPDX-License-Identifier: MIT
#include "tests/toy_set.h"

#include <filesystem>
#include <stdexcept>

#include "graph/interface.h"
#include "graph/shader_compiler.h"
#include "tests/toy_nodes.h"

namespace penumbra::test {
namespace {

const std::filesystem::path root = PENUMBRA_SOURCE_DIR;

NodeEntry compile_toy(const std::filesystem::path& file) {
    Diagnostics diagnostics;
    const auto json = read_json(file, diagnostics);
    auto type = json ? parse_node_type(*json, file.stem().string(), toy_domain(), diagnostics) : std::nullopt;
    if (!type) throw std::runtime_error(diagnostics.text());
    NodeEntry entry;
    for (const Variant& variant : all_variants(*type)) {
        const ShaderSource source{file.parent_path() / type->shader,
                                  generate_glsl(*type, variant),
                                  {root / "shaders", root / "include"}};
        auto shader = compile_shader(source, diagnostics);
        if (!shader) throw std::runtime_error(diagnostics.text());
        entry.shaders[to_string(variant)] = std::move(shader->spirv);
    }
    entry.type = std::move(*type);
    return entry;
}

}  // namespace

const NodeSet& toy_set() {
    static const NodeSet set = [] {
        NodeSet nodes;
        for (const char* name : {"toy_add", "toy_blend", "toy_chain", "toy_double", "toy_fill", "toy_list",
                                 "toy_pick", "toy_scatter", "toy_tally"})
            nodes.add(compile_toy(root / "tests/toy" / (std::string(name) + ".json")));
        return nodes;
    }();
    return set;
}

CheckedPipeline toy_pipeline_file() {
    Diagnostics diagnostics;
    const auto pipeline = load_pipeline(root / "tests/toy/toys.json", {}, diagnostics);
    auto checked = pipeline ? check(*pipeline, toy_set(), diagnostics) : std::nullopt;
    if (!checked) throw std::runtime_error(diagnostics.text());
    return std::move(*checked);
}

}  // namespace penumbra::test
