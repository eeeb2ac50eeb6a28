// SPDX-License-Identifier: MIT
// Visibility images as `render` and `reference` leave them in a folder: visibility.NNNN.exr and a word about
// the truth.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/image_file.h"

namespace penumbra {

// reference.json: how good the truth is.
struct ReferenceInfo {
    std::string shot;
    std::array<uint32_t, 2> size{};
    bool exact = false;            // a closed form
    std::optional<uint32_t> rays;  // per pixel, else
};

void write_reference_info(const std::filesystem::path& folder, const ReferenceInfo& info);
std::optional<ReferenceInfo> read_reference_info(const std::filesystem::path& folder,
                                                 Diagnostics& diagnostics);

std::filesystem::path visibility_file(const std::filesystem::path& folder, uint32_t frame);

// Numbers of the visibility images in a folder, rising; an error where there is no such folder.
std::optional<std::vector<uint32_t>> visibility_frames(const std::filesystem::path& folder,
                                                       Diagnostics& diagnostics);

}  // namespace penumbra
