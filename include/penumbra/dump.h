// SPDX-License-Identifier: MIT
// Plans for people: text (also the golden form of tests) and Graphviz dot.
#pragma once

#include <string>

#include "penumbra/plan.h"

namespace penumbra {

std::string to_text(const Plan& plan);
std::string to_dot(const Plan& plan);

}  // namespace penumbra
