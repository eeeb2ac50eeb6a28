// SPDX-License-Identifier: MIT
// Names of results, for errors a person can act on.
#include "penumbra/vulkan.h"

namespace penumbra {
namespace {

std::string result_name(VkResult result) {
    switch (result) {
        case VK_ERROR_OUT_OF_HOST_MEMORY:
            return "VK_ERROR_OUT_OF_HOST_MEMORY";
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
            return "VK_ERROR_OUT_OF_DEVICE_MEMORY";
        case VK_ERROR_INITIALIZATION_FAILED:
            return "VK_ERROR_INITIALIZATION_FAILED";
        case VK_ERROR_DEVICE_LOST:
            return "VK_ERROR_DEVICE_LOST";
        case VK_ERROR_MEMORY_MAP_FAILED:
            return "VK_ERROR_MEMORY_MAP_FAILED";
        case VK_ERROR_LAYER_NOT_PRESENT:
            return "VK_ERROR_LAYER_NOT_PRESENT";
        case VK_ERROR_EXTENSION_NOT_PRESENT:
            return "VK_ERROR_EXTENSION_NOT_PRESENT";
        case VK_ERROR_FEATURE_NOT_PRESENT:
            return "VK_ERROR_FEATURE_NOT_PRESENT";
        case VK_ERROR_INCOMPATIBLE_DRIVER:
            return "VK_ERROR_INCOMPATIBLE_DRIVER";
        case VK_ERROR_TOO_MANY_OBJECTS:
            return "VK_ERROR_TOO_MANY_OBJECTS";
        case VK_ERROR_FORMAT_NOT_SUPPORTED:
            return "VK_ERROR_FORMAT_NOT_SUPPORTED";
        case VK_ERROR_FRAGMENTED_POOL:
            return "VK_ERROR_FRAGMENTED_POOL";
        case VK_ERROR_OUT_OF_POOL_MEMORY:
            return "VK_ERROR_OUT_OF_POOL_MEMORY";
        case VK_ERROR_INVALID_OPAQUE_CAPTURE_ADDRESS:
            return "VK_ERROR_INVALID_OPAQUE_CAPTURE_ADDRESS";
        case VK_TIMEOUT:
            return "VK_TIMEOUT";
        case VK_NOT_READY:
            return "VK_NOT_READY";
        case VK_INCOMPLETE:
            return "VK_INCOMPLETE";
        default:
            return "VkResult " + std::to_string(static_cast<int>(result));
    }
}

}  // namespace

#define PENUMBRA_DESTROYER(Handle, function)          \
    template <>                                       \
    void destroy<Handle>(VkDevice device, Handle h) { \
        function(device, h, nullptr);                 \
    }
PENUMBRA_DESTROYER(VkBuffer, vkDestroyBuffer)
PENUMBRA_DESTROYER(VkBufferView, vkDestroyBufferView)
PENUMBRA_DESTROYER(VkCommandPool, vkDestroyCommandPool)
PENUMBRA_DESTROYER(VkDescriptorPool, vkDestroyDescriptorPool)
PENUMBRA_DESTROYER(VkDescriptorSetLayout, vkDestroyDescriptorSetLayout)
PENUMBRA_DESTROYER(VkDeviceMemory, vkFreeMemory)
PENUMBRA_DESTROYER(VkFence, vkDestroyFence)
PENUMBRA_DESTROYER(VkImage, vkDestroyImage)
PENUMBRA_DESTROYER(VkImageView, vkDestroyImageView)
PENUMBRA_DESTROYER(VkPipeline, vkDestroyPipeline)
PENUMBRA_DESTROYER(VkPipelineCache, vkDestroyPipelineCache)
PENUMBRA_DESTROYER(VkPipelineLayout, vkDestroyPipelineLayout)
PENUMBRA_DESTROYER(VkQueryPool, vkDestroyQueryPool)
PENUMBRA_DESTROYER(VkSampler, vkDestroySampler)
PENUMBRA_DESTROYER(VkShaderModule, vkDestroyShaderModule)
#undef PENUMBRA_DESTROYER

void check(VkResult result, const char* call, std::string_view what) {
    if (result == VK_SUCCESS) return;
    throw VulkanError(
        result, std::string(call) + " failed with " + result_name(result) + " (" + std::string(what) + ")");
}

}  // namespace penumbra
