// SPDX-License-Identifier: MIT
// What declarations and pipelines say of themselves, as pages of Markdown: docs/nodes.md and
// docs/pipeline_list.md.
#pragma once

#include <string>
#include <vector>

#include "penumbra/graph.h"

namespace penumbra {

// A section for a node type: what it is for, its ports, parameters and counters.
std::string node_section(const NodeType& type);
// A section for a pipeline: what it is for, what it takes and gives, its nodes with what it sets.
std::string pipeline_section(const CheckedPipeline& pipeline);

// All of them, with a heading and the command that writes the page.
std::string nodes_page(const NodeSet& nodes);
std::string pipelines_page(const std::vector<CheckedPipeline>& pipelines);

}  // namespace penumbra
