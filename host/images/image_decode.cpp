// SPDX-License-Identifier: MIT
// stb_image in a translation unit of its own, with no more formats than glTF has: each one left out is one
// that cannot be attacked.
#include "host/images/image_decode.h"

#include <algorithm>
#include <limits>
#include <memory>

#include "host/images/image_checks.h"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#include <stb/stb_image.h>

namespace penumbra {

std::optional<RgbaImage> decode_image(std::span<const std::byte> bytes, uint64_t limit) {
    if (bytes.empty() || bytes.size() > static_cast<size_t>(std::numeric_limits<int>::max()))
        return std::nullopt;
    if (!is_sound_image(bytes)) return std::nullopt;
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
    const int size = static_cast<int>(bytes.size());
    int width = 0, height = 0, channels = 0;
    if (!stbi_info_from_memory(data, size, &width, &height, &channels) || width < 1 || height < 1)
        return std::nullopt;
    if (uint64_t(width) * uint64_t(height) * 4 > limit) return std::nullopt;
    const std::unique_ptr<stbi_uc, void (*)(void*)> texels(
        stbi_load_from_memory(data, size, &width, &height, &channels, 4), stbi_image_free);
    if (!texels) return std::nullopt;
    const size_t count = size_t(width) * size_t(height) * 4;
    return RgbaImage{static_cast<uint32_t>(width), static_cast<uint32_t>(height),
                     std::vector<uint8_t>(texels.get(), texels.get() + count)};
}

}  // namespace penumbra
