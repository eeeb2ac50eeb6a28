// SPDX-License-Identifier: MIT
// EXT_meshopt_compression: buffer views whose bytes are to be decoded from another buffer.
#pragma once

#include <tiny_gltf.h>

#include <string>

namespace penumbra {

// A .gltf's or .glb's bytes with a stand-in for every buffer that is only a place for decoded bytes: such a buffer needs
// no data, which tinygltf would refuse. Bytes that are no glTF come back as they are.
std::string without_fallback_buffers(std::string bytes);

// Replaces every compressed view by its decoded bytes. GltfError.
void decode_meshopt(tinygltf::Model& file);

}  // namespace penumbra
