// SPDX-License-Identifier: MIT
// Reading the parameters of a declaration (node_type.cpp reads the rest).
#pragma once

#include "penumbra/node_type.h"

namespace penumbra {

// Appends the parameters of the section "params".
void parse_params(const Json& section, NodeType& type, Diagnostics& diagnostics);

}  // namespace penumbra
