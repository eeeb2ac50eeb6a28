// SPDX-License-Identifier: MIT
// Facts as the command line spells them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "penumbra/plan.h"

namespace penumbra {

// "a,!b"; nothing, and a message on stderr, where a name is no fact of the domain or stands there both ways.
std::optional<Facts> parse_facts(const std::string& text, const Domain& domain);

// Warnings of facts that were given as false and that the plan takes for true all the same.
std::vector<std::string> facts_not_taken(const Plan& plan, const Facts& given);

}  // namespace penumbra
