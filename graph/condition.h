// SPDX-License-Identifier: MIT
// Comparing conditions: what lets two nodes write one name.
#pragma once

#include "graph/node_type.h"

namespace penumbra {

// A literal and its negation, or two different values of one parameter.
bool contradict(const Literal& a, const Literal& b);

// Whether the two can never hold together.
bool exclusive(const Condition& a, const Condition& b);

}  // namespace penumbra
