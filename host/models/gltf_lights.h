// SPDX-License-Identifier: MIT
// KHR_lights_punctual: points and spots, each with a name of its own, and the nodes of suns.
#pragma once

#include <tiny_gltf.h>

#include "host/models/gltf_extension.h"
#include "host/models/model.h"

namespace penumbra {

// The light that `node` holds, if any; `self` is the model's node. GltfError.
void read_light(const tinygltf::Model& file, const tinygltf::Node& node, int self, Model& model,
                const GltfTell& tell);

// Of several of one name (nodes may share a light) the first keeps it, the others are called as their nodes
// are, or by a number: a shot names a light by this.
void name_lights(Model& model);

}  // namespace penumbra
