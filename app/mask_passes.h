// SPDX-License-Identifier: MIT
// Which passes make the mask: what it costs is theirs, in every figure that we give.
#pragma once

#include <string>
#include <vector>

#include "penumbra/plan.h"

namespace penumbra {

// Per pass of the plan: whether `signal` depends on it, in this frame or through history. Guides and
// classification are among them; lighting, anti-aliasing and what the host does before (shadow maps, trees of
// triangles) are not.
std::vector<bool> passes_of_mask(const Plan& plan, const std::string& signal = "visibility");

}  // namespace penumbra
