// SPDX-License-Identifier: MIT
#include "app/node_folders.h"

#include <iostream>

#include "app/progress.h"
#include "penumbra/shadow_nodes.h"
#include "penumbra/user_nodes.h"

namespace penumbra {

std::optional<NodeSet> read_nodes(const std::vector<std::string>& folders, Diagnostics& diagnostics) {
    NodeSet nodes = shadow_nodes();
    const auto cache = open_shader_cache(default_shader_cache(), print_warning);
    for (const std::string& folder : folders) add_user_nodes(nodes, folder, diagnostics, cache);
    return diagnostics.empty() ? std::optional(std::move(nodes)) : std::nullopt;
}

std::optional<NodeSet> open_nodes(const std::vector<std::string>& folders) {
    Diagnostics diagnostics;
    auto nodes = read_nodes(folders, diagnostics);
    if (!nodes) std::cerr << diagnostics.text();
    return nodes;
}

}  // namespace penumbra
