// SPDX-License-Identifier: MIT
// Handles of the standalone host.
#include "host/device/vulkan.h"

#include "penumbra/error.h"

namespace penumbra {
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
PENUMBRA_DESTROYER(VkFramebuffer, vkDestroyFramebuffer)
PENUMBRA_DESTROYER(VkImage, vkDestroyImage)
PENUMBRA_DESTROYER(VkImageView, vkDestroyImageView)
PENUMBRA_DESTROYER(VkPipeline, vkDestroyPipeline)
PENUMBRA_DESTROYER(VkPipelineCache, vkDestroyPipelineCache)
PENUMBRA_DESTROYER(VkPipelineLayout, vkDestroyPipelineLayout)
PENUMBRA_DESTROYER(VkQueryPool, vkDestroyQueryPool)
PENUMBRA_DESTROYER(VkRenderPass, vkDestroyRenderPass)
PENUMBRA_DESTROYER(VkSampler, vkDestroySampler)
PENUMBRA_DESTROYER(VkShaderModule, vkDestroyShaderModule)
PENUMBRA_DESTROYER(VkSwapchainKHR, vkDestroySwapchainKHR)
#undef PENUMBRA_DESTROYER

void check(VkResult result, const char* call, std::string_view what) {
    if (result == VK_SUCCESS) return;
    throw VulkanError(
        result, std::string(call) + " failed with " + result_name(result) + " (" + std::string(what) + ")");
}

}  // namespace penumbra
