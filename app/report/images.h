// SPDX-License-Identifier: MIT
// Masks and their errors as pictures.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>

namespace penumbra::report {

// Grey, 1 = white.
void write_mask_image(const std::filesystem::path& file, std::array<uint32_t, 2> size,
                      std::span<const float> mask);

// Too bright is orange, too dark is blue, right is white; colours are full at an error of `error_at_full`.
// What does not count is grey.
inline constexpr double error_at_full = 0.5;
void write_error_image(const std::filesystem::path& file, std::array<uint32_t, 2> size,
                       std::span<const float> mask, std::span<const float> truth,
                       std::span<const uint8_t> counted);

// Throw FileError where the file cannot be read. The second is an address that a page can hold.
std::string file_bytes(const std::filesystem::path& file);
std::string data_uri(const std::filesystem::path& file);

// The linear colour of an error.
std::array<float, 3> error_color(double error);

}  // namespace penumbra::report
