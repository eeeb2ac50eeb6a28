// SPDX-License-Identifier: MIT
// A pipeline cut down to what makes one of its outputs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "penumbra/check.h"
#include "penumbra/node_set.h"

namespace penumbra {

// `signal`: an output, or any resource that its nodes make. An error where there is none of that name, or
// where it takes what only an engine can bring.
std::optional<CheckedPipeline> signal_pipeline(const std::filesystem::path& file, const std::string& signal,
                                               const std::vector<std::string>& settings, const NodeSet& nodes,
                                               Diagnostics& diagnostics);

}  // namespace penumbra
