// SPDX-License-Identifier: MIT
// What ships, for tests that go over all of it.
#pragma once

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"
#include "tests/golden_text.h"

namespace penumbra::test {

inline const NodeSet& shipped_nodes() {
    static const NodeSet set = shadow_nodes();
    return set;
}

// Names without `.json`, in order.
inline std::vector<std::string> pipeline_files() {
    std::vector<std::string> names =
        names_in(std::filesystem::path(PENUMBRA_SOURCE_DIR) / "pipelines", ".json");
    std::erase_if(names, [](const std::string& name) { return name.ends_with(".schema"); });
    return names;
}

// Those that a scene feeds: the denoisers alone want a host's own rays.
inline std::vector<std::string> rendering_pipeline_files() {
    std::vector<std::string> names = pipeline_files();
    std::erase_if(names, [](const std::string& name) { return name.starts_with("denoise"); });
    return names;
}

// Of pipelines/NAME.json. Throws with the diagnostics where a setting is wrong.
inline CheckedPipeline shipped_pipeline(const std::string& name,
                                        const std::vector<std::string>& settings = {},
                                        const NodeSet& nodes = shipped_nodes()) {
    Diagnostics diagnostics;
    const auto pipeline = load_pipeline(
        std::filesystem::path(PENUMBRA_SOURCE_DIR) / "pipelines" / (name + ".json"), settings, diagnostics);
    auto checked = pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
    if (!checked) throw std::runtime_error(diagnostics.text());
    return std::move(*checked);
}

// What a host must say of its own inputs: of how many lights its list is.
inline std::map<std::string, HostResource> told_inputs(const CheckedPipeline& pipeline) {
    if (!pipeline.input("lights")) return {};
    return {{"lights", {Format::rgba32ui, {5, 1}}}};
}

}  // namespace penumbra::test
