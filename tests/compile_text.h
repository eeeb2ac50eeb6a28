// SPDX-License-Identifier: MIT
// Pipelines in a few words over a few node types without shaders, compiled for a device that is not there.
#pragma once

#include <optional>
#include <string>

#include "penumbra/graph.h"

namespace penumbra::test {

// A source, a filter with history, an in-place update and an optional extra output.
NodeSet small_set();

Target target_of(Extent extent, bool cpu = false);

struct CompiledText {
    std::optional<Plan> plan;
    std::string errors;
};

// `body`: the pipeline's keys but for its version and name. Throws std::runtime_error where it cannot be
// checked.
CompiledText compile_text(const NodeSet& set, const std::string& body, const Target& target,
                          const CompileOptions& options = {});

const PlanPass& pass_of(const Plan& plan, const std::string& node);          // throws where there is none
const PlanResource* resource_of(const Plan& plan, const std::string& name);  // nullptr: there is none
bool is_bound(const PlanPass& pass, const std::string& port);                // something is behind it
size_t position(const Plan& plan, const std::string& node);                  // of its pass
void expect_sound(const Plan& plan);                                         // by the independent checks

}  // namespace penumbra::test
