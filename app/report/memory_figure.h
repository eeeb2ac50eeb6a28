// SPDX-License-Identifier: MIT
// A plan's memory over two frames: passes from left to right, bytes upwards, a box per resource and frame
// where it lies and as long as it lives. What stands above and below each other in one place at different
// times is aliased.
#pragma once

#include <string>

#include "penumbra/plan.h"

namespace penumbra::report {

// `style` is the class of the pipeline's colour.
std::string memory_figure(const Plan& plan, const std::string& style);

}  // namespace penumbra::report
