// SPDX-License-Identifier: MIT
// What moves in a glTF file: animations of nodes and of morph weights, and skins.
#pragma once

#include <tiny_gltf.h>

#include <vector>

#include "host/models/gltf_primitive.h"
#include "host/models/model.h"

namespace penumbra {

// Morph targets of a mesh, which is the file's, and so the model's: of a node with instances the model's node
// has none.
size_t targets_of(const Model& model, int mesh);

// `model_node`: the model's node for each of the file's, -1 where it is not shown. What cannot be played is
// told. GltfError.
void read_animations(const tinygltf::Model& file, AccessorReader& accessors, ReadBudget& budget,
                     const std::vector<int>& model_node, Model& model, const GltfTell& tell);

// Skins of the file, in its order; one with joints that are not shown has none, and is told of. GltfError.
void read_skins(const tinygltf::Model& file, AccessorReader& accessors, const std::vector<int>& model_node,
                Model& model, const GltfTell& tell);

// GltfError where a vertex is moved by a joint that its node's skin does not have.
void check_joints(const Model& model);

}  // namespace penumbra
