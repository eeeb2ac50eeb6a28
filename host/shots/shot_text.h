// SPDX-License-Identifier: MIT
// JSON as a person would write a shot.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace penumbra {

// Every key of the whole on a line of its own; below that, whatever has room in a line stands on one. Ends
// with a line break.
std::string shot_text(const nlohmann::ordered_json& shot);

}  // namespace penumbra
