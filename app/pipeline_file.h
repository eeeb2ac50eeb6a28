// SPDX-License-Identifier: MIT
// A pipeline file, loaded and checked against penumbra's node set; errors go to standard error.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/shots/shot.h"
#include "penumbra/graph.h"

namespace penumbra {

// `shot`: whose lights stand in the place of those that the file names of its family "lights", if it has
// one; `light`: only the one of this name, if any.
std::optional<CheckedPipeline> open_pipeline(const std::string& file,
                                             const std::vector<std::string>& settings, const NodeSet& nodes,
                                             const Shot* shot = nullptr, const std::string& light = {});

}  // namespace penumbra
