// SPDX-License-Identifier: MIT
// When a plan's pasts are as good as they get.
#pragma once

#include "penumbra/plan.h"

namespace penumbra {

// Plan::settles.
std::optional<uint32_t> frames_to_settle(const Plan& plan);

}  // namespace penumbra
