// SPDX-License-Identifier: MIT
// The host's device with its functions loaded; owners of one object each; memory, the host's or our own.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "graph/functions.h"
#include "penumbra/device.h"
#include "penumbra/error.h"

namespace penumbra {

// Throws Failure unless `result` is VK_SUCCESS. `call` is the function's name, `what` the object or pass.
void require(VkResult result, const char* call, const std::string& what);
[[noreturn]] void fail(ErrorCode code, std::string place, std::string text);
// Those that a physical device is asked with. Throws Failure where one is missing, or what gives them is
// null.
VulkanFunctions instance_functions(const DeviceHandles& handles);

class GraphDevice {
  public:
    // Throws Failure where a handle or a function is missing, the device is older than Vulkan 1.3, or it has
    // no such queue family.
    explicit GraphDevice(const DeviceHandles& handles);

    VkDevice get() const { return handles_.device; }
    const DeviceHandles& handles() const { return handles_; }
    const VulkanFunctions& vk() const { return vk_; }
    const VkPhysicalDeviceProperties& properties() const { return properties_; }
    const std::vector<VkQueueFamilyProperties>& queue_families() const { return queue_families_; }

    MemoryBlock allocate(const MemoryRequest& request) const;
    void release(const MemoryBlock& block) const;

    // The name that debuggers and validation show, where the host has enabled debug utils.
    template <class Handle>
    void name(VkObjectType type, Handle handle, const std::string& text) const {
        set_name(type, reinterpret_cast<uint64_t>(handle), text);
    }

    void destroy(VkBuffer h) const { vk_.vkDestroyBuffer(get(), h, nullptr); }
    void destroy(VkBufferView h) const { vk_.vkDestroyBufferView(get(), h, nullptr); }
    void destroy(VkDescriptorPool h) const { vk_.vkDestroyDescriptorPool(get(), h, nullptr); }
    void destroy(VkDescriptorSetLayout h) const { vk_.vkDestroyDescriptorSetLayout(get(), h, nullptr); }
    void destroy(VkImage h) const { vk_.vkDestroyImage(get(), h, nullptr); }
    void destroy(VkImageView h) const { vk_.vkDestroyImageView(get(), h, nullptr); }
    void destroy(VkPipeline h) const { vk_.vkDestroyPipeline(get(), h, nullptr); }
    void destroy(VkPipelineCache h) const { vk_.vkDestroyPipelineCache(get(), h, nullptr); }
    void destroy(VkPipelineLayout h) const { vk_.vkDestroyPipelineLayout(get(), h, nullptr); }
    void destroy(VkQueryPool h) const { vk_.vkDestroyQueryPool(get(), h, nullptr); }
    void destroy(VkSampler h) const { vk_.vkDestroySampler(get(), h, nullptr); }
    void destroy(VkShaderModule h) const { vk_.vkDestroyShaderModule(get(), h, nullptr); }

  private:
    void set_name(VkObjectType type, uint64_t handle, const std::string& text) const;

    DeviceHandles handles_;
    VulkanFunctions vk_;
    VkPhysicalDeviceProperties properties_{};
    VkPhysicalDeviceMemoryProperties memory_{};
    std::vector<VkQueueFamilyProperties> queue_families_;
};
using DevicePtr = std::shared_ptr<const GraphDevice>;

// Sole owner of a device object; moves, never copies. The device outlives it.
template <class Handle>
class Held {
  public:
    Held() = default;
    Held(const GraphDevice& device, Handle handle) : device_(&device), handle_(handle) {}
    Held(Held&& other) noexcept
        : device_(other.device_), handle_(std::exchange(other.handle_, VK_NULL_HANDLE)) {}
    Held& operator=(Held&& other) noexcept {
        std::swap(device_, other.device_);
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Held() {
        if (handle_ != VK_NULL_HANDLE) device_->destroy(handle_);
    }
    Handle get() const { return handle_; }
    explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }

  private:
    const GraphDevice* device_ = nullptr;
    Handle handle_ = VK_NULL_HANDLE;
};

class HeldMemory {
  public:
    HeldMemory() = default;
    HeldMemory(const GraphDevice& device, const MemoryRequest& request)
        : device_(&device), block_(device.allocate(request)), bytes_(request.need.size) {}
    HeldMemory(HeldMemory&& other) noexcept { *this = std::move(other); }
    HeldMemory& operator=(HeldMemory&& other) noexcept {
        std::swap(device_, other.device_);
        std::swap(block_, other.block_);
        std::swap(bytes_, other.bytes_);
        return *this;
    }
    ~HeldMemory() {
        if (device_) device_->release(block_);
    }
    const MemoryBlock& block() const { return block_; }
    VkDeviceSize bytes() const { return bytes_; }

  private:
    const GraphDevice* device_ = nullptr;
    MemoryBlock block_;
    VkDeviceSize bytes_ = 0;
};

// A buffer of its own, host-visible and coherent memory, mapped for its lifetime; what commands copy or clear
// into (TRANSFER_DST) the host reads.
class MappedBuffer {
  public:
    MappedBuffer() = default;
    MappedBuffer(const GraphDevice& device, VkDeviceSize bytes, VkBufferUsageFlags usage,
                 const std::string& what);
    VkBuffer get() const { return buffer_.get(); }
    std::byte* data() const { return static_cast<std::byte*>(memory_.block().mapped); }
    VkDeviceSize size() const { return size_; }
    VkDeviceSize allocated() const { return memory_.bytes(); }

  private:
    HeldMemory memory_;  // declared first: freed after the buffer
    Held<VkBuffer> buffer_;
    VkDeviceSize size_ = 0;
};

}  // namespace penumbra
