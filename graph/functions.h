// SPDX-License-Identifier: MIT
// Vulkan's functions, as the host's loader gives them: nothing here is linked to one.
#pragma once

#include <vulkan/vulkan_core.h>

namespace penumbra {

#define PENUMBRA_INSTANCE_FUNCTIONS(X)          \
    X(vkEnumerateDeviceExtensionProperties)     \
    X(vkGetDeviceProcAddr)                      \
    X(vkGetPhysicalDeviceFormatProperties)      \
    X(vkGetPhysicalDeviceImageFormatProperties) \
    X(vkGetPhysicalDeviceMemoryProperties)      \
    X(vkGetPhysicalDeviceProperties)            \
    X(vkGetPhysicalDeviceProperties2)           \
    X(vkGetPhysicalDeviceFeatures2)             \
    X(vkGetPhysicalDeviceQueueFamilyProperties)

#define PENUMBRA_DEVICE_FUNCTIONS(X)       \
    X(vkAllocateDescriptorSets)            \
    X(vkAllocateMemory)                    \
    X(vkBindBufferMemory)                  \
    X(vkBindImageMemory)                   \
    X(vkCmdBindDescriptorSets)             \
    X(vkCmdBindPipeline)                   \
    X(vkCmdClearColorImage)                \
    X(vkCmdCopyBuffer)                     \
    X(vkCmdCopyBufferToImage)              \
    X(vkCmdCopyImage)                      \
    X(vkCmdCopyImageToBuffer)              \
    X(vkCmdDispatch)                       \
    X(vkCmdDispatchIndirect)               \
    X(vkCmdFillBuffer)                     \
    X(vkCmdPipelineBarrier2)               \
    X(vkCmdPushConstants)                  \
    X(vkCmdResetQueryPool)                 \
    X(vkCmdWriteTimestamp2)                \
    X(vkCreateBuffer)                      \
    X(vkCreateBufferView)                  \
    X(vkCreateComputePipelines)            \
    X(vkCreateDescriptorPool)              \
    X(vkCreateDescriptorSetLayout)         \
    X(vkCreateImage)                       \
    X(vkCreateImageView)                   \
    X(vkCreatePipelineCache)               \
    X(vkCreatePipelineLayout)              \
    X(vkCreateQueryPool)                   \
    X(vkCreateSampler)                     \
    X(vkCreateShaderModule)                \
    X(vkDestroyBuffer)                     \
    X(vkDestroyBufferView)                 \
    X(vkDestroyDescriptorPool)             \
    X(vkDestroyDescriptorSetLayout)        \
    X(vkDestroyImage)                      \
    X(vkDestroyImageView)                  \
    X(vkDestroyPipeline)                   \
    X(vkDestroyPipelineCache)              \
    X(vkDestroyPipelineLayout)             \
    X(vkDestroyQueryPool)                  \
    X(vkDestroySampler)                    \
    X(vkDestroyShaderModule)               \
    X(vkFreeMemory)                        \
    X(vkGetBufferMemoryRequirements)       \
    X(vkGetDeviceBufferMemoryRequirements) \
    X(vkGetDeviceImageMemoryRequirements)  \
    X(vkGetImageMemoryRequirements)        \
    X(vkGetImageSubresourceLayout)         \
    X(vkGetPipelineCacheData)              \
    X(vkGetQueryPoolResults)               \
    X(vkMapMemory)                         \
    X(vkUpdateDescriptorSets)

// Of VK_EXT_debug_utils: null where the host has not said that it is enabled (DeviceHandles::debug_utils).
#define PENUMBRA_DEBUG_FUNCTIONS(X) \
    X(vkCmdBeginDebugUtilsLabelEXT) \
    X(vkCmdEndDebugUtilsLabelEXT)   \
    X(vkSetDebugUtilsObjectNameEXT)

struct VulkanFunctions {
#define PENUMBRA_MEMBER(name) PFN_##name name = nullptr;
    PENUMBRA_INSTANCE_FUNCTIONS(PENUMBRA_MEMBER)
    PENUMBRA_DEVICE_FUNCTIONS(PENUMBRA_MEMBER)
    PENUMBRA_DEBUG_FUNCTIONS(PENUMBRA_MEMBER)
#undef PENUMBRA_MEMBER
};

}  // namespace penumbra
