// SPDX-License-Identifier: MIT
// The JSON Schema (draft 7) of plan.json. Every key is there, none besides.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace penumbra {

nlohmann::ordered_json plan_schema();

}  // namespace penumbra
