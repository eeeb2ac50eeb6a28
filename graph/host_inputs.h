// SPDX-License-Identifier: MIT
// What each host input of a plan is made of: one format and extent that the pipeline, the host and every
// reader agree on, and the format in which a copy keeps its previous value.
#pragma once

#include <map>
#include <string>

#include "graph/select.h"

namespace penumbra {

struct ResolvedInputs {
    std::map<std::string, HostResource> brought;  // images and texels that selected nodes read
    std::map<std::string, Format> kept;           // kept_copy(name) -> format of the copy
};

ResolvedInputs resolve_inputs(const CheckedPipeline& pipeline, const Selection& selection,
                              const Target& target, Diagnostics& diagnostics);

}  // namespace penumbra
