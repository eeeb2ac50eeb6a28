// SPDX-License-Identifier: MIT
// One glTF primitive, wherever the file keeps its attributes and indices: in accessors, or compressed by
// KHR_draco_mesh_compression.
#pragma once

#include <tiny_gltf.h>

#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "host/models/gltf_accessor.h"
#include "host/models/gltf_extension.h"
#include "host/models/model.h"

namespace penumbra {

// How a material's textures are looked up: by which coordinates, and what is done to them.
struct TextureUse {
    int coordinates = 0;  // TEXCOORD_n
    glm::dmat3 transform{1};
    bool operator==(const TextureUse&) const = default;
};

// With KHR_texture_transform. GltfError.
TextureUse texture_use(const tinygltf::TextureInfo& info);

// Its triangles, for add_part(); nothing where there are none to draw, which `tell` hears of. GltfError.
std::optional<Part> read_primitive(const tinygltf::Model& file, AccessorReader& accessors, ReadBudget& budget,
                                   const tinygltf::Primitive& primitive, const TextureUse& use,
                                   const GltfTell& tell);

}  // namespace penumbra
