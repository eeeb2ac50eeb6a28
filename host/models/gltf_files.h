// SPDX-License-Identifier: MIT
// The files of a glTF, parsed by tinygltf and not yet believed: the document, and the bytes of images before
// anything decodes them.
#pragma once

#include <tiny_gltf.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "penumbra/diagnostic.h"

namespace penumbra {

struct GltfFiles {
    tinygltf::Model model;                             // buffers are read, images are not decoded
    std::vector<std::vector<std::byte>> loose_images;  // by image: of those with a URI; else empty
    uint64_t bytes = 0;                                // of all files together
    std::vector<std::string> unread;                   // by image: why its file was not read; else empty
};

// Reads a .gltf or .glb and the files that it names. Other files than regular ones are not read, nor more
// bytes than input_limit() allows.
std::optional<GltfFiles> read_gltf_files(const std::filesystem::path& path, Diagnostics& diagnostics);

// What a file calls an image: `image "wood.png"`, or by its number.
std::string image_name(const tinygltf::Model& file, size_t image);

// The bytes of an image, still encoded: checked to lie in its buffer. Throws GltfError.
std::span<const std::byte> encoded_image(const GltfFiles& files, size_t image);

}  // namespace penumbra
