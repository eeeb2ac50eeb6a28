// SPDX-License-Identifier: MIT
// Plans for people and tools: text (also the golden form of tests), Graphviz dot, and JSON with the keys of
// report.json.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "graph/plan.h"

namespace penumbra {

std::string to_text(const Plan& plan);
std::string to_dot(const Plan& plan);

// {"passes": [...], "culled": [...], "memory": {...}, ...}; unknown values are null, never absent.
nlohmann::ordered_json to_json(const Plan& plan);
nlohmann::ordered_json passes_json(const Plan& plan);
nlohmann::ordered_json culled_json(const Plan& plan);
nlohmann::ordered_json memory_json(const Plan& plan);
nlohmann::ordered_json facts_json(const Plan& plan);

}  // namespace penumbra
