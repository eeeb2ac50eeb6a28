// SPDX-License-Identifier: MIT
// Lights with passes of their own, which need not run in every frame.
#pragma once

#include <string>
#include <vector>

#include "penumbra/plan.h"

namespace penumbra {

// Those of `names`, by their places in it, whose members of the plan may sleep where they show nothing: they
// have an input of the light's own, and what they bring from frame to frame may begin cleared. (Others would
// reset the frame in which they wake, which is worse than to run.)
std::vector<size_t> lights_that_may_sleep(const Plan& plan, const std::vector<std::string>& names);

}  // namespace penumbra
