// SPDX-License-Identifier: MIT
// Members of a glTF extension's object, and factors, which some files have a little beyond what they may be.
#pragma once

#include <tiny_gltf.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "host/models/gltf_accessor.h"

namespace penumbra {

// Told what of a file is not shown as it says, once per text.
using GltfTell = std::function<void(const std::string&)>;

// At most `most`, which is told where more than rounding is cut off; GltfError below 0 and for NaN.
double factor(const std::string& what, double value, double most, const GltfTell& tell);

// A whole number of an extension's object; GltfError, with the extension's name, where there is none.
int extension_integer(const tinygltf::Value& object, const char* key, const char* extension);
// A texture of an extension's object, as tinygltf reads those of the core; GltfError.
tinygltf::TextureInfo extension_texture(const tinygltf::Value& object, const char* key,
                                        const char* extension);
// `otherwise` where there is none; GltfError, with the extension's name, where it is something else.
double extension_number(const tinygltf::Value& object, const char* key, const std::string& extension,
                        double otherwise);
// Numbers of a list; those that the object does not have stay as `out` has them.
void extension_numbers(const tinygltf::Value& object, const char* key, const char* extension,
                       std::span<double> out);

}  // namespace penumbra
