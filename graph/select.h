// SPDX-License-Identifier: MIT
// Which nodes of a pipeline run in one case of facts, what each of their ports is connected to, and in which
// order.
#pragma once

#include <optional>
#include <vector>

#include "penumbra/check.h"
#include "penumbra/plan.h"

namespace penumbra {

enum class Source : uint8_t { none, host, internal };

struct SelectedNode {
    const BoundNode* node = nullptr;  // nullptr: captures `capture`
    uint32_t capture = no_resource;
    std::vector<Source> sources;  // parallel to the type's ports; none: the port does not exist in this plan
};

struct Selection {
    std::vector<SelectedNode> nodes;  // in execution order
    std::vector<Culled> culled;
};

// `left_out` are inputs, by index, that the host does not bring; captures are resources. Reports a capture
// that nobody writes.
std::optional<Selection> select(const CheckedPipeline& pipeline, size_t facts,
                                const std::vector<bool>& left_out, const std::vector<std::string>& captures,
                                Diagnostics& diagnostics);

}  // namespace penumbra
