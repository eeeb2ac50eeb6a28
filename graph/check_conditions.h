// SPDX-License-Identifier: MIT
// A part of check(): in which cases of the facts each node, port and table is there.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graph/instances.h"
#include "penumbra/check.h"

namespace penumbra {

// Of the pipeline's nodes, which of the checked ones each is: nothing where its type is unknown.
using NodesById = std::map<std::string, std::optional<size_t>>;

// Fills in `cases`, `condition` and `tables` of the nodes. A node that is there in no case stays: its names
// and wires are checked as any other's. `sources`: what each node was written as, in `written_out`.
void settle_conditions(CheckedPipeline& pipeline, const std::vector<const PipelineNode*>& sources,
                       const WrittenOut& written_out, const NodesById& ids, Diagnostics& diagnostics);

}  // namespace penumbra
