// SPDX-License-Identifier: MIT
// JSON as text, whatever its strings hold. Names of files need not be UTF-8, and dump() throws at one that is
// not: then all that the JSON was to tell would be lost.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace penumbra {

// `indent`: spaces per level; below 0 all is one line. Bytes that are no UTF-8 become U+FFFD.
template <class Json>
std::string json_dump(const Json& json, int indent = -1) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace penumbra
