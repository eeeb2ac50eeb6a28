// SPDX-License-Identifier: MIT
// Whether numbers, flags, indices, strings and lists of them in a glTF's JSON are what glTF 2.0 says that
// they are. tinygltf takes one of another type for one that is not there, and the picture would be another
// one.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace penumbra {

// The first one that is not, "nodes[3].scale: expected a list of 3 numbers"; else nothing. Looks at those
// alone that this program reads.
std::string wrong_member(const nlohmann::json& gltf);

}  // namespace penumbra
