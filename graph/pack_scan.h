// SPDX-License-Identifier: MIT
// A packing in one pass, for sets that are too large to compare every interval with every other.
#pragma once

#include <span>

#include "graph/pack.h"

namespace penumbra {

// As pack(): never larger than the sum of the aligned sizes. The time grows with the intervals times those
// live at once.
Packing scan_packing(std::span<const Interval> intervals, uint32_t period);

}  // namespace penumbra
