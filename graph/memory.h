// SPDX-License-Identifier: MIT
// A plan's resources on a device: one allocation per heap, and for each resource two instances (by frame
// parity; of what is kept one), each an image or a buffer bound at the offset that the packer chose.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "graph/device.h"
#include "penumbra/view.h"

namespace penumbra {

// The memory of a plan's shared heaps, for views that run one after another (program.h).
class TransientMemory {
  public:
    TransientMemory(DevicePtr device, std::span<const Plan* const> plans);
    const GraphDevice& device() const { return *device_; }
    // The block of a plan's heap; throws Failure where it does not fit.
    const MemoryBlock& heap(const Plan& plan, uint32_t heap) const;
    uint64_t bytes() const;

  private:
    struct Part {
        Heap heap;
        HeldMemory memory;
    };
    DevicePtr device_;
    std::vector<Part> parts_;
};

HeldMemory allocate_heap(const GraphDevice& device, const Heap& heap);

// Throws Failure unless the plan was compiled for this device: its offsets hold where every resource takes
// what it took then.
void check_device(const Plan& plan, const DeviceHandles& handles);

class PlanMemory {
  public:
    // `transients`: of the shared heaps; null: these too are this plan's alone.
    PlanMemory(const GraphDevice& device, const Plan& plan,
               std::shared_ptr<const TransientMemory> transients);
    const ResourceHandles& at(uint32_t resource, uint32_t parity) const {
        return instances_[resource][kept_[resource] ? 0 : parity].handles;
    }
    // Of a mip chain: one level alone, to be written. Null: there is no chain.
    VkImageView level(uint32_t resource, uint32_t parity, uint32_t level) const;
    // What has an image's memory (PlanResource::row_bytes); null: nothing.
    VkBuffer rows(uint32_t resource, uint32_t parity) const;
    uint64_t bytes() const;  // allocated for this view alone
    bool shares() const { return transients_ != nullptr; }

  private:
    struct Instance {
        ResourceHandles handles;
        Held<VkImage> image;
        Held<VkImageView> image_view;
        std::vector<Held<VkImageView>> level_views;
        Held<VkBuffer> buffer, rows;
        Held<VkBufferView> buffer_view;
    };
    void make_image(const PlanResource& r, const MemoryBlock& heap, uint32_t parity, Instance& out) const;
    void make_buffer(const PlanResource& r, const MemoryBlock& heap, uint32_t parity, Instance& out) const;
    Held<VkBuffer> buffer(const PlanResource& r, const MemoryBlock& heap, uint32_t parity,
                          VkBufferUsageFlags usage) const;
    Held<VkImageView> image_view(const PlanResource& r, VkImage image, uint32_t first_level,
                                 uint32_t levels) const;

    const GraphDevice& device_;
    std::shared_ptr<const TransientMemory> transients_;
    std::vector<HeldMemory> heaps_;  // by heap; empty: shared
    std::vector<std::array<Instance, 2>> instances_;
    std::vector<bool> kept_;  // one instance stands for both parities
};

}  // namespace penumbra
