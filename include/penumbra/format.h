// SPDX-License-Identifier: MIT
// The closed list of texel formats a port may name, and what each phase needs to know about one.
#pragma once

#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "penumbra/export.h"

namespace penumbra PENUMBRA_API {

enum class Format : uint8_t {
    r8,
    rg8,
    rgba8,
    r16f,
    rg16f,
    rg16s,
    rgba16f,
    r32f,
    rg32f,
    rgba32f,
    r32ui,
    rg32ui,
    rgba32ui,
    rgb10a2,
    r11g11b10f,
    d32,
    d16
};
inline constexpr int format_count = 17;

enum class FormatClass : uint8_t { unorm, snorm, real, uint, depth };

struct FormatInfo {
    const char* name;
    VkFormat vk;
    uint32_t bytes;  // per texel
    uint32_t channels;
    FormatClass kind;
    const char* glsl;  // layout qualifier of a storage image; nullptr: cannot be storage
};

const FormatInfo& info(Format format);
std::optional<Format> format_named(std::string_view name);
std::vector<std::string> format_names();

}  // namespace penumbra
