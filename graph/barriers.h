// SPDX-License-Identifier: MIT
// Dependencies of a plan's passes, from declared uses alone. Pure.
#pragma once

#include "penumbra/plan.h"

namespace penumbra {

// Fills before, after_clears and end of a plan whose uses, lifetimes and offsets are known.
void place_barriers(Plan& plan);

}  // namespace penumbra
