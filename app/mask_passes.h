// SPDX-License-Identifier: MIT
// Of a plan: which passes make the mask, whose cost is what every figure of ours means by it, and whether it
// remembers.
#pragma once

#include <string>
#include <vector>

#include "penumbra/plan.h"

namespace penumbra {

// Per pass of the plan: whether `signal` depends on it, in this frame or through history. Guides and
// classification are among them; lighting, anti-aliasing and what the host does before (shadow maps, trees of
// triangles) are not.
std::vector<bool> passes_of_mask(const Plan& plan, const std::string& signal = "visibility");

// Whether a frame's images may depend on frames before it, through what the graph or its host keeps. Memos,
// which only spare work, do not count.
bool has_history(const Plan& plan);

}  // namespace penumbra
