// SPDX-License-Identifier: MIT
// Owning Vulkan handles and checked calls. A thin stand-in for vk::raii, whose header costs several seconds
// in every translation unit: an owner destroys one handle, check() turns a VkResult into an exception that
// names the call.
#pragma once

#include <vulkan/vulkan_core.h>

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace penumbra {

// A Vulkan call failed: "vkAllocateMemory failed with VK_ERROR_OUT_OF_DEVICE_MEMORY (heap 0, 64 MiB)".
class VulkanError : public std::runtime_error {
  public:
    VulkanError(VkResult result, const std::string& text) : std::runtime_error(text), result_(result) {}
    VkResult result() const { return result_; }

  private:
    VkResult result_;
};

// Throws VulkanError unless `result` is VK_SUCCESS. `call` is the function's name, `what` the object or pass.
void check(VkResult result, const char* call, std::string_view what);

// The function that destroys a handle whose parent is a VkDevice.
template <class Handle>
struct Destroyer;

#define PENUMBRA_DESTROYER(Handle, function)                                             \
    template <>                                                                          \
    struct Destroyer<Handle> {                                                           \
        static void destroy(VkDevice device, Handle h) { function(device, h, nullptr); } \
    }
PENUMBRA_DESTROYER(VkBuffer, vkDestroyBuffer);
PENUMBRA_DESTROYER(VkBufferView, vkDestroyBufferView);
PENUMBRA_DESTROYER(VkCommandPool, vkDestroyCommandPool);
PENUMBRA_DESTROYER(VkDescriptorPool, vkDestroyDescriptorPool);
PENUMBRA_DESTROYER(VkDescriptorSetLayout, vkDestroyDescriptorSetLayout);
PENUMBRA_DESTROYER(VkDeviceMemory, vkFreeMemory);
PENUMBRA_DESTROYER(VkFence, vkDestroyFence);
PENUMBRA_DESTROYER(VkImage, vkDestroyImage);
PENUMBRA_DESTROYER(VkImageView, vkDestroyImageView);
PENUMBRA_DESTROYER(VkPipeline, vkDestroyPipeline);
PENUMBRA_DESTROYER(VkPipelineCache, vkDestroyPipelineCache);
PENUMBRA_DESTROYER(VkPipelineLayout, vkDestroyPipelineLayout);
PENUMBRA_DESTROYER(VkQueryPool, vkDestroyQueryPool);
PENUMBRA_DESTROYER(VkSampler, vkDestroySampler);
PENUMBRA_DESTROYER(VkShaderModule, vkDestroyShaderModule);
#undef PENUMBRA_DESTROYER

// Sole owner of a device object; moves, never copies.
template <class Handle>
class Owned {
  public:
    Owned() = default;
    Owned(VkDevice device, Handle handle) : device_(device), handle_(handle) {}
    Owned(Owned&& other) noexcept
        : device_(other.device_), handle_(std::exchange(other.handle_, VK_NULL_HANDLE)) {}
    Owned& operator=(Owned&& other) noexcept {
        std::swap(device_, other.device_);
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Owned() {
        if (handle_ != VK_NULL_HANDLE) Destroyer<Handle>::destroy(device_, handle_);
    }
    Handle get() const { return handle_; }
    explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }

  private:
    VkDevice device_ = VK_NULL_HANDLE;
    Handle handle_ = VK_NULL_HANDLE;
};

}  // namespace penumbra
