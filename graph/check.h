// SPDX-License-Identifier: MIT
// A pipeline whose every name is resolved against a node set: what compile() starts from. check() reports
// every error a pipeline can have, under any combination of facts, so that compile() cannot fail on the
// pipeline's account.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graph/pipeline.h"

namespace penumbra {

class NodeSet;

// One port of one node, bound (or not) to a resource name.
struct BoundPort {
    const Port* port = nullptr;
    std::string resource;   // empty: unbound (optional ports only)
    bool previous = false;  // reads resource@-1
    Place place;
};

struct BoundNode {
    std::string id;
    const NodeType* type = nullptr;
    std::vector<BoundPort> ports;  // in the type's order, every port once
    std::map<std::string, ParamValue>
        params;  // every parameter, defaults filled in (class overrides are not)
    std::map<std::string, bool>
        set_by_user;                // parameters the pipeline sets itself: class overrides leave these
    FactCases cases = all_cases();  // the facts under which it runs: "if", with its comparisons settled
    std::string condition;          // "if", as text
    Place place;
    bool added = false;  // by the graph, not by the pipeline's text: not worth a word where it does not run
};

struct CheckedPipeline {
    std::string name, doc, file;
    std::vector<HostInput> inputs;  // kind filled in from the readers
    std::vector<BoundNode> nodes;   // in the file's order
    std::vector<ResourceSetting> resources;
    std::vector<std::string> outputs;
};

// `nodes` must outlive the result.
std::optional<CheckedPipeline> check(const Pipeline& pipeline, const NodeSet& nodes,
                                     Diagnostics& diagnostics);

}  // namespace penumbra
