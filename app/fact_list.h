// SPDX-License-Identifier: MIT
// Facts as the command line spells them.
#pragma once

#include <optional>
#include <string>

#include "graph/node_type.h"

namespace penumbra {

// "a,!b"; nothing, and a message on stderr, where a name is no fact.
std::optional<Facts> parse_facts(const std::string& text);

}  // namespace penumbra
