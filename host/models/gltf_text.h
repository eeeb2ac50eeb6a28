// SPDX-License-Identifier: MIT
// What has to be known of, or done to, a glTF file's JSON before tinygltf reads it.
#pragma once

#include <string>

namespace penumbra {

// A .gltf's or .glb's bytes as tinygltf takes them: with a byte of data in every buffer that EXT_meshopt_compression
// has as a place for decoded bytes alone, and without the indices of primitives that Draco holds, whose accessors have
// no data. Bytes that are no glTF come back as they are.
std::string taken_by_tinygltf(std::string bytes);

// "1.0" of a file of that version, whose scenes and meshes are objects instead of lists; nothing where it may be 2.0.
std::string old_version(const std::string& bytes);

}  // namespace penumbra
