// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string_view>

#include "host/images/image_file.h"

namespace penumbra {

// As write_file.
inline void write_text(const std::filesystem::path& path, std::string_view text) {
    write_file(path, std::as_bytes(std::span(text)));
}

}  // namespace penumbra
