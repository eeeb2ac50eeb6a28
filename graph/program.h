// SPDX-License-Identifier: MIT
// A plan's shaders and tables on a device, shared by any number of views of one queue. Immutable after
// construction but for the one upload of the tables, which the first frame recorded carries.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "graph/memory.h"
#include "graph/plan.h"
#include "graph/vulkan.h"

namespace penumbra {

struct PassProgram {
    std::array<Owned<VkDescriptorSetLayout>, 2> set_layouts;
    Owned<VkPipelineLayout> layout;
    Owned<VkPipeline> pipeline;
};

struct TableImage {
    std::string name;  // "node type/table"
    Owned<VkDeviceMemory> memory;
    Owned<VkImage> image;
    Owned<VkImageView> view;
    MappedBuffer staging;
    std::array<uint32_t, 2> extent{1, 1};
};

class Program {
  public:
    // Throws VulkanError. `plan` was compiled for this device (device_table(handles)).
    Program(const DeviceHandles& handles, std::shared_ptr<const Plan> plan);

    const DeviceHandles& handles() const { return handles_; }
    const Plan& plan() const { return *plan_; }
    const PassProgram& pass(size_t index) const { return passes_[index]; }
    VkSampler sampler(bool linear) const { return samplers_[linear].get(); }
    const TableImage& table(const std::string& node_type, const std::string& name) const;

    // Copies the tables to the device; recorded before anything that reads them, once per program.
    void record_uploads(VkCommandBuffer cmd) const;

  private:
    void make_tables();
    void make_pass(size_t index);

    DeviceHandles handles_;
    std::shared_ptr<const Plan> plan_;
    std::array<Owned<VkSampler>, 2> samplers_;
    Owned<VkPipelineCache> cache_;
    std::vector<PassProgram> passes_;
    std::vector<TableImage> tables_;
    mutable bool uploaded_ = false;
};

// Whether a binding is the level of a mip chain that a dispatch writes; the next binding is the finer level.
bool writes_chain(const PlanBinding& binding);

VkDescriptorType descriptor_type(const Plan& plan, const PlanPass& pass, const PlanBinding& binding);

}  // namespace penumbra
