// SPDX-License-Identifier: MIT
// A pipeline that checks itself: every host image that it reads and everything that its nodes write gets a
// node of type `validate` behind it, which counts what is not finite or outside of the range that the
// declaration promises. A transformation of the checked pipeline: compile() and the runtime see ordinary
// nodes, and a pipeline that was not transformed pays nothing.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "penumbra/check.h"
#include "penumbra/plan.h"

namespace penumbra {

// Left out is what holds no numbers (words, structs) or is written in part, and previous values, which were
// looked at in the frame that wrote them. The watchers change nothing about what else runs (see
// NodeType::watches). Reports a node set without a type "validate" of the shape that
// nodes/tools/validate.json has.
std::optional<CheckedPipeline> with_validation(const CheckedPipeline& pipeline, const NodeSet& nodes,
                                               Diagnostics& diagnostics);

// A pass that validates, be it added or the pipeline's own.
struct ValidatePass {
    size_t pass = 0;
    std::string resource;  // what it looks at: "color", "depth"
    std::string origin;    // who wrote that: "nodes.taa.out.color", "inputs.depth"
};
std::vector<ValidatePass> validate_passes(const Plan& plan);

}  // namespace penumbra
