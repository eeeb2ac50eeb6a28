// SPDX-License-Identifier: MIT
// Independent checks of a plan, sharing no code with the compiler: bytes x time overlaps by walking two
// frames pass by pass, and missing dependencies by walking frames with every access and every barrier.
#pragma once

#include <string>
#include <vector>

#include "penumbra/plan.h"

namespace penumbra::test {

// Pairs of resource instances that hold data in the same bytes at the same time; uses outside a lifetime.
// Empty: none.
std::vector<std::string> overlap_errors(const Plan& plan);

// Accesses that no dependency orders after what they depend on. Empty: none.
std::vector<std::string> hazard_errors(const Plan& plan);

}  // namespace penumbra::test
