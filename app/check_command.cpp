// SPDX-License-Identifier: MIT
// penumbra check: every error of every file, on standard error, those of a user's shaders among them.
#include <iostream>

#include "app/commands.h"
#include "app/node_folders.h"
#include "app/pipeline_file.h"
#include "penumbra/user_nodes.h"

namespace penumbra {
namespace {

bool check_file(const std::string& file, const NodeSet& nodes) {
    const auto pipeline = open_pipeline(file, {}, nodes);
    if (!pipeline) return false;
    Diagnostics diagnostics;
    const bool good = compile_user_nodes(nodes, *pipeline, diagnostics);
    std::cerr << diagnostics.text();
    return good;
}

}  // namespace

int run_check(const CheckArguments& arguments) {
    const auto nodes = open_nodes(arguments.node_folders);
    if (!nodes) return exit_wrong;
    bool good = true;
    for (const std::string& file : arguments.pipelines) {
        // pipelines/*.json is what people type
        if (file.ends_with(".schema.json"))
            std::cerr << file << ": a JSON Schema, not a pipeline; not checked\n";
        else
            good = check_file(file, *nodes) && good;
    }
    return good ? exit_good : exit_wrong;
}

}  // namespace penumbra
