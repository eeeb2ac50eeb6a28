// SPDX-License-Identifier: MIT
// What ships, for tests that go over all of it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

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

}  // namespace penumbra::test
