// SPDX-License-Identifier: MIT
// Animated pictures for pages and documents.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace penumbra {

// A WebP file that plays for ever: frames of width x height 8-bit RGBA texels, rows from the top, each shown
// for `frame_ms`. Lossy, for the eye. Throws FileError where there is no frame, where one has another size,
// or where WebP cannot hold it (16383 texels a side).
std::vector<std::byte> webp_animation(uint32_t width, uint32_t height,
                                      std::span<const std::vector<uint8_t>> frames, int frame_ms);

}  // namespace penumbra
