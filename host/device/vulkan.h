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

// Destroys a handle whose parent is a VkDevice; of the types that vulkan.cpp lists.
template <class Handle>
void destroy(VkDevice device, Handle handle);

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
        if (handle_ != VK_NULL_HANDLE) destroy(device_, handle_);
    }
    Handle get() const { return handle_; }
    explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }

  private:
    VkDevice device_ = VK_NULL_HANDLE;
    Handle handle_ = VK_NULL_HANDLE;
};

}  // namespace penumbra
