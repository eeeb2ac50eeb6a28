// SPDX-License-Identifier: MIT
// A node of the host's own, whose GLSL is compiled when the program runs: the component glsl.
#include <cstdio>

#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"
#include "penumbra/user_nodes.h"

// In place of shadow.json, which extends a pipeline of the source tree. Extended is a file beside the name
// given to parse_pipeline.
const char* const text = R"({ "extends": "raw.json", "inputs": { "albedo": null }, "outputs": ["shadow"],
    "nodes": { "shade": null, "invert": { "type": "invert", "params": { "gain": 1 } } } })";

int main() {
    penumbra::Diagnostics errors;
    penumbra::NodeSet nodes = penumbra::shadow_nodes();
    penumbra::add_user_nodes(nodes, EXAMPLE "/nodes", errors, penumbra::open_shader_cache(""));
    const auto pipeline = penumbra::parse_pipeline(text, PIPELINES "/shadow.json", {}, errors);
    const auto checked = pipeline ? penumbra::check(*pipeline, nodes, errors) : std::nullopt;
    const auto plan =
        checked ? penumbra::compile(*checked, {.extent = {640, 360}, .device = penumbra::reference_device()},
                                    {}, errors)
                : std::nullopt;
    if (!plan || !errors.empty()) {
        std::fputs(errors.text().c_str(), stderr);
        return 2;
    }
    std::printf("invert: %zu words of SPIR-V\n", plan->modules[*plan->pass("invert")->module].size());
}
