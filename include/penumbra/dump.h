// SPDX-License-Identifier: MIT
// Plans for people: text (also the golden form of tests) and Graphviz dot.
#pragma once

#include <string>

#include "penumbra/export.h"
#include "penumbra/plan.h"

namespace penumbra PENUMBRA_API {

std::string to_text(const Plan& plan);
std::string to_dot(const Plan& plan);

}  // namespace penumbra
