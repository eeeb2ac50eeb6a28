// SPDX-License-Identifier: MIT
// The JSON Schema of pipeline files, for editors that complete and check while one types: node types, their
// ports and parameters with ranges and docs, all from the declarations. What needs the whole dataflow is
// check()'s.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "graph/node_set.h"

namespace penumbra {

nlohmann::ordered_json pipeline_schema(const NodeSet& nodes);

}  // namespace penumbra
