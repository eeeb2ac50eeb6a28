// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "graph/device.h"
#include "penumbra/plan.h"

namespace penumbra {

// Collects descriptor writes. The infos they point to stay put until flush(), since there is room for as many
// as were asked for.
class DescriptorWriter {
  public:
    DescriptorWriter(const GraphDevice& device, size_t room);
    void image(VkDescriptorSet set, const PlanBinding& b, const VkDescriptorImageInfo& info);
    void buffer(VkDescriptorSet set, const PlanBinding& b, const VkDescriptorBufferInfo& info);
    void texels(VkDescriptorSet set, const PlanBinding& b, VkBufferView view);
    void structure(VkDescriptorSet set, const PlanBinding& b, VkAccelerationStructureKHR handle);
    void flush();

  private:
    VkWriteDescriptorSet& write(VkDescriptorSet set, const PlanBinding& b);

    const GraphDevice* device_;
    std::vector<VkWriteDescriptorSet> writes_;
    std::vector<VkDescriptorImageInfo> images_;
    std::vector<VkDescriptorBufferInfo> buffers_;
    std::vector<VkBufferView> views_;
    std::vector<VkAccelerationStructureKHR> handles_;
    std::vector<VkWriteDescriptorSetAccelerationStructureKHR> structures_;
};

}  // namespace penumbra
