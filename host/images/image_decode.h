// SPDX-License-Identifier: MIT
// PNG and JPEG, as models bring them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace penumbra {

struct RgbaImage {
    uint32_t width = 0, height = 0;
    std::vector<uint8_t> rgba;  // 8 bits per channel, rows from the top; of 16 bits the upper 8
};

// Nothing where the bytes are no such image, or where it takes more than `limit` bytes decoded.
std::optional<RgbaImage> decode_image(std::span<const std::byte> bytes, uint64_t limit);

}  // namespace penumbra
