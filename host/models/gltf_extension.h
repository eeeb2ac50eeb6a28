// SPDX-License-Identifier: MIT
// Members of a glTF extension's object.
#pragma once

#include <tiny_gltf.h>

#include <span>
#include <string>
#include <vector>

#include "host/models/gltf_accessor.h"

namespace penumbra {

// A whole number of an extension's object; GltfError, with the extension's name, where there is none.
int extension_integer(const tinygltf::Value& object, const char* key, const char* extension);
// Numbers of a list; those that the object does not have stay as `out` has them.
void extension_numbers(const tinygltf::Value& object, const char* key, const char* extension,
                       std::span<double> out);

}  // namespace penumbra
