// SPDX-License-Identifier: MIT
// Texels as numbers, at the ends of what each format holds.
#include "host/images/texels.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>

namespace penumbra {
namespace {

template <typename Word, size_t N>
std::vector<std::vector<float>> decoded(Format format, const std::array<Word, N>& words) {
    const auto count = static_cast<uint32_t>(sizeof words / info(format).bytes);
    const std::vector<std::string> names{"x", "y", "z", "w"};
    const PlanarImage image = decode_texels(format, count, 1, std::as_bytes(std::span(words)), names);
    std::vector<std::vector<float>> planes;
    for (const auto& plane : image.planes) planes.push_back(plane.values);
    return planes;
}

using Planes = std::vector<std::vector<float>>;

// The lowest word of signed ones has no counterpart, and is -1 like the one above it.
TEST(Texels, SignedAndUnsignedShares) {
    EXPECT_EQ(decoded(Format::rg16s, std::array<int16_t, 6>{-32768, -32767, 0, 32767, -16384, 1}),
              (Planes{{-1, 0, -16384.0f / 32767}, {-1, 1, 1.0f / 32767}}));
    EXPECT_EQ(decoded(Format::rg8, std::array<uint8_t, 4>{0, 255, 1, 128}),
              (Planes{{0, 1.0f / 255}, {1, 128.0f / 255}}));
    EXPECT_EQ(decoded(Format::d16, std::array<uint16_t, 3>{0, 65535, 1}), (Planes{{0, 1, 1.0f / 65535}}));
    EXPECT_EQ(decoded(Format::rgb10a2, std::array<uint32_t, 1>{3u << 30 | 1023u << 10 | 1}),
              (Planes{{1.0f / 1023}, {1}, {0}, {1}}));
}

TEST(Texels, Halves) {
    const Planes planes =
        decoded(Format::r16f, std::array<uint16_t, 5>{0x3C00, 0xC000, 0x0001, 0x7BFF, 0x7C00});
    EXPECT_EQ(planes[0],
              (std::vector<float>{1, -2, 0x1p-24f, 65504, std::numeric_limits<float>::infinity()}));
}

}  // namespace
}  // namespace penumbra
