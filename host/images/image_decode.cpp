// SPDX-License-Identifier: MIT
#include "host/images/image_decode.h"

#include <algorithm>
#include <initializer_list>

namespace penumbra {

RgbaImage decode_image(std::span<const std::byte> bytes, uint64_t limit) {
    const auto begins = [&](std::initializer_list<int> signature) {
        return bytes.size() >= signature.size() &&
               std::equal(signature.begin(), signature.end(), bytes.begin(),
                          [](int a, std::byte b) { return std::byte(a) == b; });
    };
    if (begins({0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'})) return decode_png(bytes, limit);
    if (begins({0xff, 0xd8, 0xff})) return decode_jpeg(bytes, limit);
    throw ImageError("neither a PNG nor a JPEG");
}

}  // namespace penumbra
