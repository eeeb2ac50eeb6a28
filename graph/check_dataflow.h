// SPDX-License-Identifier: MIT
// What the parts of check() share: who writes and who reads each name.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "graph/check.h"

namespace penumbra {

// One port's use of a resource. `cases` are the facts under which node and port exist.
struct PortUse {
    size_t node = 0;  // index into CheckedPipeline::nodes
    const BoundPort* bound = nullptr;
    FactCases cases;
    Place place;
    std::string path;  // "nodes.filter0.in.signal"
};

struct ResourceUse {
    const HostInput* host = nullptr;
    std::vector<PortUse> writers, readers;  // in the file's order
};

// One memory for all frames: no previous value, and no other name for it.
inline bool is_kept(const ResourceUse& use) {
    return std::ranges::any_of(use.writers,
                               [](const PortUse& w) { return w.bound->port->writes == Writes::kept; });
}

struct Dataflow {
    const CheckedPipeline& pipeline;
    std::vector<OutputName> outputs;
    std::map<std::string, ResourceUse> resources;
};

// Every reader has exactly one writer under all facts; chains of updates have one end; no cycle within a
// frame.
void check_dataflow(const Dataflow& dataflow, Diagnostics& diagnostics);

// Both ends of every wire fit each other; fills in the kinds of `inputs`, which are dataflow.pipeline's.
void check_wires(const Dataflow& dataflow, std::vector<HostInput>& inputs, const NodeSet& nodes,
                 Diagnostics& diagnostics);

}  // namespace penumbra
