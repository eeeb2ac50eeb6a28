// SPDX-License-Identifier: MIT
// A plan's resources on a device: one allocation per heap, and for each resource two instances (by frame
// parity), each an image or a buffer bound at the offset that the packer chose.
#pragma once

#include <array>
#include <vector>

#include "penumbra/export.h"
#include "penumbra/plan.h"
#include "penumbra/vulkan.h"

namespace PENUMBRA_API penumbra {

// The host's device. Penumbra creates no instance, device or queue of its own and submits nothing.
struct DeviceHandles {
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    uint32_t queue_family = 0;
};

// Limits, format features and memory sizes of a real device, which must outlive the table. Which features are
// enabled cannot be asked of a device: the caller fills them in.
DeviceTable device_table(const DeviceHandles& handles);

// The first memory type of `type_bits` with all `wanted` properties; throws VulkanError where there is none.
uint32_t memory_type(VkPhysicalDevice physical, uint32_t type_bits, VkMemoryPropertyFlags wanted);

struct ResourceInstance {
    Owned<VkImage> image;
    Owned<VkImageView> image_view;
    std::vector<Owned<VkImageView>> level_views;  // of a mip chain: each level alone, to be written
    Owned<VkBuffer> buffer;
    Owned<VkBufferView> buffer_view;
    VkDeviceSize bytes = 0;
};

// A buffer of its own, host-visible and coherent memory, mapped for its lifetime.
class MappedBuffer {
  public:
    MappedBuffer() = default;
    MappedBuffer(const DeviceHandles& handles, VkDeviceSize bytes, VkBufferUsageFlags usage,
                 std::string_view what);
    VkBuffer get() const { return buffer_.get(); }
    std::byte* data() const { return data_; }
    VkDeviceSize size() const { return size_; }

  private:
    Owned<VkDeviceMemory> memory_;  // declared first: freed after the buffer
    Owned<VkBuffer> buffer_;
    std::byte* data_ = nullptr;
    VkDeviceSize size_ = 0;
};

class PlanMemory {
  public:
    PlanMemory(const DeviceHandles& handles, const Plan& plan);
    const ResourceInstance& at(uint32_t resource, uint32_t parity) const {
        return instances_[resource][kept_[resource] ? 0 : parity];
    }

  private:
    std::vector<Owned<VkDeviceMemory>> heaps_;
    std::vector<std::array<ResourceInstance, 2>> instances_;
    std::vector<bool> kept_;  // one instance stands for both parities
};

}  // namespace penumbra
