// SPDX-License-Identifier: MIT
// A member of a family of instances that is asleep: a lamp that is off. Its passes rest, but for those that
// hand on what the member before it has left (`@before`), and what these and others read of the resting ones
// is 0.
#pragma once

#include "penumbra/plan.h"

namespace penumbra {

// Fills in PlanPass::zero_at_rest, and lets these resources be cleared. Lifetimes are known.
void place_rests(Plan& plan);

}  // namespace penumbra
