// SPDX-License-Identifier: MIT
// Which type of a device's memory an allocation takes.
#pragma once

#include <vulkan/vulkan_core.h>

#include <optional>

namespace penumbra {

// The first of those allowed that has the properties; for what the host reads, if there is one, a cached one:
// others are read tens of times slower than they are written.
inline std::optional<uint32_t> memory_type(const VkPhysicalDeviceMemoryProperties& memory, uint32_t allowed,
                                           VkMemoryPropertyFlags properties, bool readback) {
    const VkMemoryPropertyFlags best =
        properties | (readback ? VkMemoryPropertyFlags{VK_MEMORY_PROPERTY_HOST_CACHED_BIT} : 0);
    for (const VkMemoryPropertyFlags wanted : {best, properties})
        for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
            if ((allowed >> i & 1) && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    return std::nullopt;
}

}  // namespace penumbra
