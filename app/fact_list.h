// SPDX-License-Identifier: MIT
// Facts as the command line spells them.
#pragma once

#include <optional>
#include <string>

#include "penumbra/plan.h"

namespace penumbra {

// "a,!b"; nothing, and a message on stderr, where a name is no fact of the domain or stands there both ways.
std::optional<Facts> parse_facts(const std::string& text, const Domain& domain);

}  // namespace penumbra
