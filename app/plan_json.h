// SPDX-License-Identifier: MIT
// Plans as JSON, with the keys of report.json.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "penumbra/plan.h"

namespace penumbra {

// {"passes": [...], "culled": [...], "memory": {...}, ...}
nlohmann::ordered_json to_json(const Plan& plan);
nlohmann::ordered_json passes_json(const Plan& plan);
nlohmann::ordered_json culled_json(const Plan& plan);
nlohmann::ordered_json memory_json(const Plan& plan);
nlohmann::ordered_json facts_json(const Plan& plan);

}  // namespace penumbra
