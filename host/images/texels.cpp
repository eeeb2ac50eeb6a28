// SPDX-License-Identifier: MIT
// Bit layouts of Vulkan's formats (Vulkan specification, "Formats"); small floats have 5 exponent bits,
// bias 15.
#include "host/images/texels.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

namespace penumbra {
namespace {

// An unsigned float of 5 exponent and `mantissa_bits` mantissa bits; half floats add a sign.
float small_float(uint32_t bits, uint32_t mantissa_bits) {
    const uint32_t mantissa = bits & ((1u << mantissa_bits) - 1);
    const uint32_t exponent = bits >> mantissa_bits & 31;
    if (exponent == 31)
        return mantissa ? std::numeric_limits<float>::quiet_NaN() : std::numeric_limits<float>::infinity();
    if (exponent == 0)
        return 0x1p-14f * static_cast<float>(mantissa) / static_cast<float>(1u << mantissa_bits);
    return std::bit_cast<float>((exponent + 127 - 15) << 23 | mantissa << (23 - mantissa_bits));
}

float half(uint32_t bits) {
    return (bits & 0x8000 ? -1.0f : 1.0f) * small_float(bits & 0x7fff, 10);
}

template <class T>
T load(const std::byte* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return value;
}

float channel_value(Format format, const std::byte* texel, size_t c) {
    switch (format) {
        case Format::r8:
        case Format::rg8:
        case Format::rgba8:
            return static_cast<float>(load<uint8_t>(texel + c)) / 255.0f;
        case Format::rg16s:
            return std::max(static_cast<float>(load<int16_t>(texel + 2 * c)) / 32767.0f, -1.0f);
        case Format::d16:
            return static_cast<float>(load<uint16_t>(texel)) / 65535.0f;
        case Format::r16f:
        case Format::rg16f:
        case Format::rgba16f:
            return half(load<uint16_t>(texel + 2 * c));
        case Format::r32f:
        case Format::rg32f:
        case Format::rgba32f:
        case Format::d32:
            return load<float>(texel + 4 * c);
        case Format::rgb10a2: {
            const uint32_t word = load<uint32_t>(texel);
            return c < 3 ? static_cast<float>(word >> (10 * c) & 1023) / 1023.0f
                         : static_cast<float>(word >> 30) / 3.0f;
        }
        case Format::r11g11b10f: {
            const uint32_t word = load<uint32_t>(texel);
            return c < 2 ? small_float(word >> (11 * c) & 0x7ff, 6) : small_float(word >> 22, 5);
        }
        default:
            return 0;
    }
}

}  // namespace

PlanarImage decode_texels(Format format, uint32_t width, uint32_t height, std::span<const std::byte> texels,
                          const std::vector<std::string>& names) {
    const FormatInfo& what = info(format);
    PlanarImage image{width, height, {}};
    const size_t count = size_t{width} * height;
    for (size_t c = 0; c < what.channels && c < names.size(); ++c) {
        Plane plane;
        plane.name = names[c];
        if (what.kind == FormatClass::uint) {
            plane.type = PlaneType::uint;
            plane.words.resize(count);
            for (size_t i = 0; i < count; ++i)
                plane.words[i] = load<uint32_t>(&texels[i * what.bytes + 4 * c]);
        } else {
            plane.values.resize(count);
            for (size_t i = 0; i < count; ++i)
                plane.values[i] = channel_value(format, &texels[i * what.bytes], c);
        }
        image.planes.push_back(std::move(plane));
    }
    return image;
}

}  // namespace penumbra
