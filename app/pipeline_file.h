// SPDX-License-Identifier: MIT
// A pipeline file, loaded and checked against penumbra's node set.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/shots/shot.h"
#include "penumbra/graph.h"

namespace penumbra {

// Puts a shot's lights into the place of those that a pipeline names of its family "lights", if it has one:
// all, or the one that is wanted by its name. Where it names lights of the shot, those alone, whose facts
// hold.
void name_lights(Pipeline& pipeline, const Shot& shot, const std::string& wanted, Diagnostics& diagnostics);

// A file, or the name of a shipped one. `shot`: whose lights are named, all or `light` alone.
std::optional<CheckedPipeline> read_pipeline(const std::string& file,
                                             const std::vector<std::string>& settings, const NodeSet& nodes,
                                             const Shot* shot, const std::string& light,
                                             Diagnostics& diagnostics);
// Errors go to standard error.
std::optional<CheckedPipeline> open_pipeline(const std::string& file,
                                             const std::vector<std::string>& settings, const NodeSet& nodes,
                                             const Shot* shot = nullptr, const std::string& light = {});

// A pipeline's file and all that it extends, as far as they can be read.
std::set<std::filesystem::path> files_of_pipeline(const std::filesystem::path& file);

}  // namespace penumbra
