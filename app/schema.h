// SPDX-License-Identifier: MIT
// The JSON Schemas (draft 7) of pipelines over a node set and of node declarations: editors complete keys,
// types, ports and parameters from them, with their docs. They accept everything that the loader accepts;
// of what it rejects they find what is wrong with a value by itself, not with names that point elsewhere.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "penumbra/node_set.h"

namespace penumbra {

nlohmann::ordered_json pipeline_schema(const NodeSet& nodes);
nlohmann::ordered_json declaration_schema(const Domain& domain);

// JSON with short values on one line.
std::string schema_text(const nlohmann::ordered_json& schema);

}  // namespace penumbra
