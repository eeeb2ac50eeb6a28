// SPDX-License-Identifier: MIT
// penumbra check: every error of every file, on standard error, those of a user's shaders among them.
#include <iostream>

#include "app/commands.h"
#include "app/node_folders.h"
#include "app/pipeline_file.h"
#include "app/reference_pages.h"
#include "penumbra/user_nodes.h"

namespace penumbra {
namespace {

std::optional<CheckedPipeline> check_file(const std::string& file, const NodeSet& nodes) {
    auto pipeline = open_pipeline(file, {}, nodes);
    if (!pipeline) return std::nullopt;
    Diagnostics diagnostics;
    const bool good = compile_user_nodes(*pipeline, diagnostics);
    std::cerr << diagnostics.text();
    return good ? std::move(pipeline) : std::nullopt;
}

}  // namespace

int run_check(const CheckArguments& arguments) {
    const auto nodes = open_nodes(arguments.node_folders);
    if (!nodes) return exit_wrong;
    bool good = true;
    std::vector<CheckedPipeline> right;
    for (const std::string& file : arguments.pipelines) {
        // pipelines/*.json is what people type
        if (file.ends_with(".schema.json"))
            std::cerr << file << ": a JSON Schema, not a pipeline; not checked\n";
        else if (auto pipeline = check_file(file, *nodes))
            right.push_back(std::move(*pipeline));
        else
            good = false;
    }
    if (good && arguments.page) std::cout << pipelines_page(right);
    return good ? exit_good : exit_wrong;
}

}  // namespace penumbra
