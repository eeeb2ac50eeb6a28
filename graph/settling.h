// SPDX-License-Identifier: MIT
// When a plan's pasts are as good as they get.
#pragma once

#include "penumbra/plan.h"

namespace penumbra {

// Plan::settles: after how many frames that are alike, one after the other, all that the plan keeps from
// frame to frame gets no better; 0 where it keeps nothing, nothing where a past feeds itself and its
// declaration does not say when it settles.
std::optional<uint32_t> frames_to_settle(const Plan& plan);

}  // namespace penumbra
