// SPDX-License-Identifier: MIT
// What moves in a glTF file: animations of nodes and of morph weights, and skins.
#pragma once

#include <tiny_gltf.h>

#include <functional>
#include <string>
#include <vector>

#include "host/models/model.h"

namespace penumbra {

// `model_node`: the model's node for each of the file's, -1 where it is not shown. `targets`: of a model's node, how many
// morph targets its mesh has. What cannot be played is told to `warn`. GltfError.
void read_animations(const tinygltf::Model& file, const std::vector<int>& model_node,
                     const std::function<size_t(int)>& targets, Model& model,
                     const std::function<void(const std::string&)>& warn);

// Skins of the file, in its order; one with joints that are not shown has none and is told to `warn`. GltfError.
void read_skins(const tinygltf::Model& file, const std::vector<int>& model_node, Model& model,
                const std::function<void(const std::string&)>& warn);

}  // namespace penumbra
