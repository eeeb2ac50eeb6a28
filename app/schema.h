// SPDX-License-Identifier: MIT
// The JSON Schema (draft 7) of pipelines over a node set: editors complete types, ports and parameters from
// it, with their docs. It accepts everything that the loader accepts; of what the loader rejects it finds
// what is wrong with a value by itself, not with names that point elsewhere.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "penumbra/node_set.h"

namespace penumbra {

nlohmann::ordered_json pipeline_schema(const NodeSet& nodes);

// JSON with short values on one line.
std::string schema_text(const nlohmann::ordered_json& schema);

}  // namespace penumbra
