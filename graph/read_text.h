// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

namespace penumbra {

// A file's contents; nothing where they cannot be read. A folder would open, and read as empty.
inline std::optional<std::string> read_text(const std::filesystem::path& path) {
    std::error_code failure;
    if (!std::filesystem::is_regular_file(path, failure)) return std::nullopt;
    std::ifstream stream(path, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(stream)), {});
    return stream ? std::optional(std::move(text)) : std::nullopt;
}

}  // namespace penumbra
