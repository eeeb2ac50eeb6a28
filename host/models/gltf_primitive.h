// SPDX-License-Identifier: MIT
// Attributes and indices of one glTF primitive, wherever the file keeps them: in accessors, or compressed by
// KHR_draco_mesh_compression.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace penumbra {

class GltfPrimitive {
  public:
    // Throws GltfError.
    GltfPrimitive(const tinygltf::Model& file, const tinygltf::Primitive& primitive);
    ~GltfPrimitive();

    bool has(const std::string& attribute) const;
    // Components of an accessor, as read_floats() needs to know them: 3 or 4 of a colour.
    int width(const std::string& attribute) const;
    // `width` floats per vertex. Throws GltfError.
    std::vector<float> floats(const std::string& attribute, int width) const;
    // Of a primitive of `vertices`; 0, 1, 2 .. where it has none. Checked to be less than `vertices`.
    std::vector<uint32_t> corners(size_t vertices) const;

  private:
    struct Decoded;  // of Draco
    const tinygltf::Model& file_;
    const tinygltf::Primitive& primitive_;
    std::unique_ptr<Decoded> decoded_;
};

}  // namespace penumbra
