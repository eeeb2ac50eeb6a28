// SPDX-License-Identifier: MIT
// Independent checks of a plan, sharing no code with the compiler: bytes x time overlaps by walking two
// frames pass by pass, and missing dependencies by walking frames with every access and every barrier.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "penumbra/plan.h"

namespace penumbra::test {

// Pairs of resource instances that hold data in the same bytes at the same time; uses, the host's of outputs
// among them, outside of the lifetime that the memory is reserved for. Empty: none.
std::vector<std::string> overlap_errors(const Plan& plan);

// Accesses that no dependency orders after what they depend on, the host's accesses of outputs among them;
// images whose first use is not told of their layout. Empty: none. Stops after `most`.
std::vector<std::string> hazard_errors(const Plan& plan, size_t most = 1000);

}  // namespace penumbra::test
