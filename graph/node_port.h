// SPDX-License-Identifier: MIT
// Reading the ports of a declaration (node_type.cpp reads the rest).
#pragma once

#include "penumbra/node_type.h"

namespace penumbra {

// A declaration's "if", against its facts and parameters; "always" after an error.
Condition read_condition(const Json& json, const std::string& path, const NodeType& type,
                         Diagnostics& diagnostics);
// Whether a condition compares this parameter.
bool asks_for(const Condition& condition, const std::string& param);

// Appends the ports of the section "inputs" or "outputs"; conditions are parsed against type.params.
void parse_ports(const Json& section, bool output, NodeType& type, Diagnostics& diagnostics);

// What ports say about each other: `updates`, `of`, and the number of shader variants. Fills in what an
// updating port inherits.
void link_ports(const Json& declaration, NodeType& type, Diagnostics& diagnostics);

}  // namespace penumbra
