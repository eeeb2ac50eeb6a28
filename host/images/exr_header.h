// SPDX-License-Identifier: MIT
// What an EXR says of its size, read before OpenEXR is: it allocates by the header's numbers, whatever the
// file holds.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace penumbra {

// Why the file is not read (a part of it takes more than input_limit(), or more than a file of so many bytes
// can hold, or claims attributes beyond the file's end), or nothing. Files that are not EXR at all pass:
// OpenEXR says so better.
std::optional<std::string> exr_size_problem(const std::filesystem::path& path);

}  // namespace penumbra
