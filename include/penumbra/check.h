// SPDX-License-Identifier: MIT
// A pipeline whose every name is resolved against a node set: what compile() starts from. check() reports
// every error a pipeline can have, under any combination of facts, so that compile() can fail on the target's
// account alone. From here on resources, ports and parameters are indices; names are there to be printed.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "penumbra/export.h"
#include "penumbra/node_set.h"
#include "penumbra/pipeline.h"

namespace penumbra PENUMBRA_API {

inline constexpr uint32_t no_resource = ~0u;

// One port of one node, bound (or not) to a resource.
struct BoundPort {
    const Port* port = nullptr;
    uint32_t resource = no_resource;  // of CheckedPipeline::resources
    bool previous = false;            // reads the previous frame's value
    FactCases cases;                  // in which node and port exist
    Place place;
};

struct BoundNode {
    std::string id;
    std::shared_ptr<const NodeEntry> entry;
    std::vector<BoundPort> ports;    // parallel to the type's
    std::vector<ParamValue> params;  // parallel to the type's; defaults filled in (class overrides are not)
    std::vector<bool> set;           // by the pipeline itself: class overrides leave these
    std::vector<FactCases> tables;   // parallel to the type's: in which they exist
    FactCases cases = all_cases();   // in which it runs: "if", with its comparisons settled
    std::string condition;           // "if", as text
    std::optional<uint32_t> with;    // of CheckedPipeline::inputs: where it is left out, so is the node
    Place place;
    bool added = false;          // not by the pipeline's text: not worth a word where it does not run
    std::string family, member;  // whose it is, of a family of instances
    bool hands_on = false;       // takes part in passing a NAME@before on to the next member

    const NodeType& type() const { return entry->type; }
};

// One name. An updating output's is another name for the same memory.
struct CheckedResource {
    std::string name;
    std::optional<uint32_t> input;  // of CheckedPipeline::inputs: the host brings it
    Format format = Format::r8;     // of what nodes write: of images and texels
    std::optional<First> first;     // the pipeline's wish
};

// Within a frame `from` comes before `to` where both run.
struct Edge {
    uint32_t from = 0, to = 0;  // of CheckedPipeline::nodes
    FactCases cases;
    friend bool operator==(const Edge&, const Edge&) = default;
};

struct CheckedPipeline {
    std::string name, doc, file;
    std::shared_ptr<const Domain> domain;
    std::vector<HostInput> inputs;  // kind filled in from the readers
    std::vector<BoundNode> nodes;   // in the file's order
    std::vector<CheckedResource> resources;
    std::vector<uint32_t> outputs;  // of resources
    std::vector<Edge> edges;

    const HostInput* input(std::string_view input_name) const;              // nullptr: no such name
    const CheckedResource* resource(std::string_view resource_name) const;  // likewise
    std::vector<std::string> output_names() const;
    // What a name is called where its previous value is meant.
    std::string name_of(const BoundPort& bound) const;
};

std::optional<CheckedPipeline> check(const Pipeline& pipeline, const NodeSet& nodes,
                                     Diagnostics& diagnostics);

}  // namespace penumbra
