// SPDX-License-Identifier: MIT
// Families of instances, written out: a node "trace" of the family "lights" becomes "trace_desk" and
// "trace_bulb", and what it writes and what the host brings to it become their own as well.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "penumbra/node_set.h"
#include "penumbra/pipeline.h"

namespace penumbra {

struct WrittenOut {
    Pipeline pipeline;  // whose inputs, nodes, settings and outputs all stand for one thing
    std::vector<const PipelineInstance*> of;  // parallel to its nodes; nullptr: of no family
    // Parallel to its nodes: reads a NAME@before, or lies within the frame between such a node and the one
    // that writes the same NAME.
    std::vector<bool> hands_on;
    std::map<std::string, std::string> own_names, own_nodes;  // each instance has its own: family

    // What a node calls by a name: its instance's own thing where there is one.
    std::string name(size_t node, const std::string& called) const { return own(own_names, node, called); }
    std::string node_id(size_t node, const std::string& called) const { return own(own_nodes, node, called); }

  private:
    std::string own(const std::map<std::string, std::string>& names, size_t node,
                    const std::string& called) const;
};

// Points into `pipeline`.
WrittenOut write_out_instances(const Pipeline& pipeline, const NodeSet& set, Diagnostics& diagnostics);

}  // namespace penumbra
