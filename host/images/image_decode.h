// SPDX-License-Identifier: MIT
// PNG and JPEG, as models bring them, by libpng and libjpeg-turbo.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

namespace penumbra {

struct RgbaImage {
    uint32_t width = 0, height = 0;
    std::vector<uint8_t> rgba;  // 8 bits per channel, rows from the top; of 16 bits rounded
};

// What is wrong with an image's bytes.
class ImageError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

// The texels as they are stored: what a file says of its colours (gamma, profiles) is left to whoever knows
// what they are for, as glTF 2.0 demands (section 3.8.3). Throws ImageError where the bytes are no such image
// or end early, or where it takes more than `limit` bytes decoded.
RgbaImage decode_image(std::span<const std::byte> bytes, uint64_t limit);

// The same of one format, with its signature: where setjmp is.
RgbaImage decode_png(std::span<const std::byte> bytes, uint64_t limit);
RgbaImage decode_jpeg(std::span<const std::byte> bytes, uint64_t limit);

}  // namespace penumbra
