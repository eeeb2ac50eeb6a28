// SPDX-License-Identifier: MIT
// The table of texel formats: Vulkan's name, size, and the GLSL layout qualifier (GLSL 4.60, section 4.4.7).
// Depth formats have no qualifier: D16 and D32 may not be storage images.
#include "penumbra/format.h"

#include <array>

namespace penumbra {

namespace {

constexpr std::array<FormatInfo, format_count> table = {{
    {"r8", VK_FORMAT_R8_UNORM, 1, 1, FormatClass::unorm, "r8"},
    {"rg8", VK_FORMAT_R8G8_UNORM, 2, 2, FormatClass::unorm, "rg8"},
    {"rgba8", VK_FORMAT_R8G8B8A8_UNORM, 4, 4, FormatClass::unorm, "rgba8"},
    {"r16f", VK_FORMAT_R16_SFLOAT, 2, 1, FormatClass::real, "r16f"},
    {"rg16f", VK_FORMAT_R16G16_SFLOAT, 4, 2, FormatClass::real, "rg16f"},
    {"rg16s", VK_FORMAT_R16G16_SNORM, 4, 2, FormatClass::snorm, "rg16_snorm"},
    {"rgba16f", VK_FORMAT_R16G16B16A16_SFLOAT, 8, 4, FormatClass::real, "rgba16f"},
    {"r32f", VK_FORMAT_R32_SFLOAT, 4, 1, FormatClass::real, "r32f"},
    {"rg32f", VK_FORMAT_R32G32_SFLOAT, 8, 2, FormatClass::real, "rg32f"},
    {"rgba32f", VK_FORMAT_R32G32B32A32_SFLOAT, 16, 4, FormatClass::real, "rgba32f"},
    {"r32ui", VK_FORMAT_R32_UINT, 4, 1, FormatClass::uint, "r32ui"},
    {"rg32ui", VK_FORMAT_R32G32_UINT, 8, 2, FormatClass::uint, "rg32ui"},
    {"rgba32ui", VK_FORMAT_R32G32B32A32_UINT, 16, 4, FormatClass::uint, "rgba32ui"},
    {"rgb10a2", VK_FORMAT_A2B10G10R10_UNORM_PACK32, 4, 4, FormatClass::unorm, "rgb10_a2"},
    {"r11g11b10f", VK_FORMAT_B10G11R11_UFLOAT_PACK32, 4, 3, FormatClass::real, "r11f_g11f_b10f"},
    {"d32", VK_FORMAT_D32_SFLOAT, 4, 1, FormatClass::depth, nullptr},
    {"d16", VK_FORMAT_D16_UNORM, 2, 1, FormatClass::depth, nullptr},
}};
static_assert(static_cast<int>(Format::d16) + 1 == format_count);

}  // namespace

const FormatInfo& info(Format format) {
    return table[static_cast<size_t>(format)];
}

std::optional<Format> format_named(std::string_view name) {
    for (size_t i = 0; i < table.size(); ++i)
        if (name == table[i].name) return static_cast<Format>(i);
    return std::nullopt;
}

std::vector<std::string> format_names() {
    std::vector<std::string> names;
    for (const FormatInfo& format : table) names.emplace_back(format.name);
    return names;
}

}  // namespace penumbra
