// SPDX-License-Identifier: MIT
// A file that the build has linked into the program (embed_files.cmake).
#pragma once

#include <span>
#include <string_view>

namespace penumbra {

struct EmbeddedFile {
    std::string_view name;
    std::string_view bytes;  // at an address that is a multiple of 16
};

// The file of this name; nullptr: there is none.
inline const EmbeddedFile* find_embedded(std::span<const EmbeddedFile> files, std::string_view name) {
    for (const EmbeddedFile& file : files)
        if (file.name == name) return &file;
    return nullptr;
}

}  // namespace penumbra
