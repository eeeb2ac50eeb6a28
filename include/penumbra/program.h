// SPDX-License-Identifier: MIT
// A plan's shaders and tables on a device, shared by any number of views of one queue. Immutable after
// construction but for the one upload of the tables, which the first frame recorded carries.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "penumbra/export.h"
#include "penumbra/memory.h"
#include "penumbra/plan.h"
#include "penumbra/vulkan.h"

namespace PENUMBRA_API penumbra {

struct PassProgram {
    std::array<Owned<VkDescriptorSetLayout>, 2> set_layouts;
    Owned<VkPipelineLayout> layout;
    Owned<VkPipeline> pipeline;
};

// An image of one texel array, sampled or stored to: a table, or what stands for an absent one.
struct StaticImage {
    Owned<VkDeviceMemory> memory;
    Owned<VkImage> image;
    Owned<VkImageView> view;
};

class Program {
  public:
    // Throws VulkanError. `plan` was compiled for this device (device_table(handles)).
    Program(const DeviceHandles& handles, std::shared_ptr<const Plan> plan);

    const DeviceHandles& handles() const { return handles_; }
    const Plan& plan() const { return *plan_; }
    const PassProgram& pass(size_t index) const { return passes_[index]; }
    VkSampler sampler(bool linear) const { return samplers_[linear].get(); }
    VkImageView table(uint32_t index) const { return tables_[index].image.view.get(); }
    // What is bound where there is nothing: never read, so that all bindings alike share one.
    VkImageView absent_image(const PlanBinding& binding) const;
    VkBufferView absent_texels(Format format) const { return absent_texels_.at(format).get(); }
    VkBuffer absent_buffer() const { return absent_buffer_.get(); }

    // Copies the tables to the device and gives what is absent its layout; recorded before anything that
    // reads them, once per program.
    void record_uploads(VkCommandBuffer cmd) const;

  private:
    struct TableImage {
        StaticImage image;
        MappedBuffer staging;
    };
    struct AbsentKey {
        Format format;
        bool storage, layered;
        friend auto operator<=>(const AbsentKey&, const AbsentKey&) = default;
    };

    StaticImage make_image(Format format, std::array<uint32_t, 2> extent, VkImageUsageFlags usage,
                           bool layered, const std::string& what) const;
    void make_tables();
    void make_absent();
    void make_pass(size_t index);

    DeviceHandles handles_;
    std::shared_ptr<const Plan> plan_;
    std::array<Owned<VkSampler>, 2> samplers_;
    Owned<VkPipelineCache> cache_;
    std::vector<PassProgram> passes_;
    std::vector<TableImage> tables_;
    std::map<AbsentKey, StaticImage> absent_images_;
    MappedBuffer absent_buffer_;
    std::map<Format, Owned<VkBufferView>> absent_texels_;
    mutable bool uploaded_ = false;
};

}  // namespace penumbra
