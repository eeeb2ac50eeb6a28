// SPDX-License-Identifier: MIT
// What the parts of check() share: who writes and who reads each name.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "penumbra/check.h"

namespace penumbra {

// One port's use of a resource.
struct PortUse {
    size_t node = 0;  // index into CheckedPipeline::nodes
    const BoundPort* bound = nullptr;
    std::string path;  // "nodes.filter0.in.signal"
};

struct ResourceUse {
    std::string name;
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
    const Pipeline& source;
    std::vector<ResourceUse> resources;  // parallel to CheckedPipeline::resources
    std::vector<uint32_t> by_name;  // resources in the order of their names, in which errors are reported
    const std::map<std::string, uint32_t>* ids;  // of the names

    const ResourceUse* find(const std::string& name) const {
        const auto found = ids->find(name);
        return found == ids->end() ? nullptr : &resources[found->second];
    }

    // The input whose memory a writer takes over; nullptr where it makes its own.
    const BoundPort* updated(const PortUse& writer) const {
        const std::optional<uint32_t> input = writer.bound->port->updated_input;
        return input ? &pipeline.nodes[writer.node].ports[*input] : nullptr;
    }
};

// Every reader has exactly one writer under all facts; chains of updates have one end; no cycle within a
// frame. The order that this asks for.
std::vector<Edge> check_dataflow(const Dataflow& dataflow, Diagnostics& diagnostics);

// Both ends of every wire fit each other; fills in the kinds of `inputs` and the formats of `resources`,
// which are dataflow.pipeline's.
void check_wires(const Dataflow& dataflow, std::vector<HostInput>& inputs,
                 std::vector<CheckedResource>& resources, Diagnostics& diagnostics);

}  // namespace penumbra
