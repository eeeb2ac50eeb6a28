// SPDX-License-Identifier: MIT
// A plan as a map: passes from left to right in dataflow order with what they write, host inputs and previous
// frames' values beside their first reader, a line per value and reader.
#pragma once

#include <string>

#include "penumbra/plan.h"

namespace penumbra::report {

// `style` is the class of the pipeline's colour.
std::string dataflow_figure(const Plan& plan, const std::string& style);

}  // namespace penumbra::report
