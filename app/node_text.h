// SPDX-License-Identifier: MIT
// Ports and parameters of a declaration in words, for the `nodes` command and for schemas.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "penumbra/node_type.h"

namespace penumbra {

std::string type_name(ParamType type);  // as declarations spell it
nlohmann::ordered_json json_of(const ParamValue& value);
std::vector<std::string> format_names_of(const Port& port);
std::string joined(const std::vector<std::string>& words, const char* separator);

std::string describe(const Port& port);    // "image r16f|r8, optional"
std::string describe(const Param& param);  // "int 1..16 px = 1"

}  // namespace penumbra
