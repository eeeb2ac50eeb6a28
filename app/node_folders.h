// SPDX-License-Identifier: MIT
// The node types a command works with: penumbra's own and those of --nodes folders.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "penumbra/node_set.h"

namespace penumbra {

std::optional<NodeSet> read_nodes(const std::vector<std::string>& folders, Diagnostics& diagnostics);
// The same; errors go to standard error.
std::optional<NodeSet> open_nodes(const std::vector<std::string>& folders);

}  // namespace penumbra
