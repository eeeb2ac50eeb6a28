// SPDX-License-Identifier: MIT
// A checked pipeline and a target to a plan: facts, culling, order, lifetimes, offsets, dependencies. Needs
// no device.
#pragma once

#include <functional>
#include <map>
#include <optional>

#include "penumbra/check.h"
#include "penumbra/export.h"
#include "penumbra/plan.h"

namespace penumbra PENUMBRA_API {

struct CompileOptions {
    bool alias = true;    // false: every resource has memory of its own
    bool poison = false;  // lets the view fill every activated resource with a pattern (tests)
    // What lives within a frame gets heaps of its own, which several views may share
    // (ViewOptions::transients).
    bool share_transients = false;
    // Lets a view of this plan inherit the history of another plan's view, and the reverse
    // (ViewOptions::heir_of); both plans need it.
    bool hand_on_history = false;
    std::vector<std::string> captures;  // resources to copy out every frame, by name
    std::map<std::string, OutputUse>
        outputs;  // by name, where OutputUse's defaults are not what the host does
    // The smallest possible heap, for reports: an exhaustive search of at most so many nodes (1 to 2 us
    // each); 0: none.
    uint64_t optimum_search_nodes = 0;
    // Called now and then during that search with the share of those nodes that it has visited, from 0 for
    // each heap; the search may end at any.
    std::function<void(double share)> optimum_progress;
};

// Errors are those a target can add: a format or feature that the device lacks, an input of a format nobody
// accepts, facts, inputs and outputs that the pipeline does not know; and a node set's, a shader that is
// missing or does not compile.
std::optional<Plan> compile(const CheckedPipeline& pipeline, const Target& target,
                            const CompileOptions& options, Diagnostics& diagnostics);

}  // namespace penumbra
