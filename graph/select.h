// SPDX-License-Identifier: MIT
// Which nodes of a pipeline run under given facts, what each of their ports is connected to, and in which
// order.
#pragma once

#include <deque>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "graph/check.h"
#include "graph/compile.h"

namespace penumbra {

enum class Source : uint8_t { none, host, internal };

struct Connection {
    const BoundPort* bound = nullptr;
    Source source = Source::none;  // none: the port does not exist in this plan
    std::string resource;          // internal: a name that some node writes; host: the slot's
    bool previous = false;
};

struct SelectedNode {
    const BoundNode* node = nullptr;  // nullptr: captures `capture`
    std::string capture;
    std::vector<Connection> ports;  // parallel to the type's ports
};

struct Selection {
    std::vector<SelectedNode> nodes;  // in execution order
    std::vector<Culled> culled;
    std::deque<BoundNode> made;  // built-in copies that keep host inputs' previous values
};

// The name of the internal resource that keeps a host input with `history: copy`.
std::string kept_copy(const std::string& input);

std::optional<Selection> select(const CheckedPipeline& pipeline, const NodeSet& nodes, const Facts& facts,
                                const std::set<std::string>& left_out,
                                const std::vector<std::string>& captures, Diagnostics& diagnostics);

}  // namespace penumbra
