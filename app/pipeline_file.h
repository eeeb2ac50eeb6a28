// SPDX-License-Identifier: MIT
// A pipeline file, loaded and checked against penumbra's node set; errors go to standard error.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "penumbra/graph.h"

namespace penumbra {

std::optional<CheckedPipeline> open_pipeline(const std::string& file,
                                             const std::vector<std::string>& settings, const NodeSet& nodes);

}  // namespace penumbra
