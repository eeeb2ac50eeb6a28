// SPDX-License-Identifier: MIT
// Plans as JSON: parts with the keys of report.json, and whole, so that a device layer that is not Vulkan's,
// or not penumbra's, can carry one out (docs/embedding.md; schema: plan_schema.h).
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "penumbra/plan.h"

namespace penumbra {

// Raised where a reader of the version before would be wrong.
inline constexpr int plan_json_version = 2;

// The whole plan. Its SPIR-V and its tables are files, named here, that write_plan() puts beside it.
nlohmann::ordered_json to_json(const Plan& plan);
std::string module_file(size_t index);
std::string table_file(size_t index);
// plan.json and those files, into a folder that is made where it is not there.
bool write_plan(const Plan& plan, const std::filesystem::path& folder, Diagnostics& diagnostics);

nlohmann::ordered_json passes_json(const Plan& plan);
nlohmann::ordered_json culled_json(const Plan& plan);
nlohmann::ordered_json memory_json(const Plan& plan);
nlohmann::ordered_json facts_json(const Plan& plan);

}  // namespace penumbra
