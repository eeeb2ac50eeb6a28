// SPDX-License-Identifier: MIT
// What each host input of a plan is made of: one format and extent that the pipeline, the host and every
// reader agree on.
#pragma once

#include "graph/select.h"

namespace penumbra {

// Inputs, by index, that the host leaves out. Reports names that are no inputs, and those that it may not
// leave out.
std::vector<bool> inputs_left_out(const CheckedPipeline& pipeline, const Target& target,
                                  Diagnostics& diagnostics);

// How an input's size follows the frame's; nothing where it has one of its own.
inline std::optional<Follows> follows_of(const HostInput& input) {
    return input.extent == HostInput::Extent::frame ? std::optional(Follows{}) : std::nullopt;
}

// By input: images and texels that selected nodes read.
std::vector<HostResource> resolve_inputs(const CheckedPipeline& pipeline, const Selection& selection,
                                         const Target& target, Diagnostics& diagnostics);

}  // namespace penumbra
