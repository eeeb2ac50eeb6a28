// SPDX-License-Identifier: MIT
// A fixed device for tests and for planning without one: tight images with rows padded to 64 bytes, alignment
// 4 KiB.
#include <algorithm>

#include "graph/align_up.h"
#include "penumbra/plan.h"

namespace penumbra {

DeviceTable reference_device(bool cpu) {
    DeviceTable table;
    table.name = cpu ? "reference cpu" : "reference gpu";
    table.cpu = cpu;
    table.limits = {{"maxComputeSharedMemorySize", 32768},
                    {"maxComputeWorkGroupCount[0]", 65535},
                    {"maxComputeWorkGroupCount[1]", 65535},
                    {"maxComputeWorkGroupCount[2]", 65535},
                    {"maxComputeWorkGroupInvocations", 1024},
                    {"maxComputeWorkGroupSize[0]", 1024},
                    {"maxComputeWorkGroupSize[1]", 1024},
                    {"maxComputeWorkGroupSize[2]", 64},
                    {"maxImageArrayLayers", 2048},
                    {"maxImageDimension2D", table.max_image_extent}};
    table.image_memory = [](const ImageNeed& need) {
        uint64_t size = 0;
        for (uint32_t level = 0; level < need.levels; ++level) {
            const uint64_t width = std::max(need.extent.width >> level, 1u),
                           height = std::max(need.extent.height >> level, 1u);
            size += align_up(width * info(need.format).bytes, 64) * height * need.layers;
        }
        return MemoryNeed{align_up(size, 4096), 4096, ~0u};
    };
    table.buffer_memory = [](uint64_t bytes, VkBufferUsageFlags) {
        return MemoryNeed{align_up(bytes, 256), 256, ~0u};
    };
    table.supports = [](Format format, VkFormatFeatureFlags features) {
        return !(features & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT) || info(format).glsl != nullptr;
    };
    return table;
}

}  // namespace penumbra
