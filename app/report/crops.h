// SPDX-License-Identifier: MIT
// Where in a picture to look.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace penumbra::report {

inline constexpr uint32_t crop_zoom = 4;  // a crop is so many times smaller than its picture

// The middle of the crop with the largest sum of squared errors, in shares of width and height from the upper
// left corner; the picture's middle where there is none. `errors`: rows from the top.
std::array<double, 2> worst_crop(std::array<uint32_t, 2> size, std::span<const uint8_t> errors);

// The part of an address behind the # that opens a shot's two pictures there (assets/page.js reads it).
std::string crop_fragment(const std::string& shot, const std::string& left, const std::string& right,
                          std::array<double, 2> middle);

}  // namespace penumbra::report
