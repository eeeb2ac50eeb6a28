// SPDX-License-Identifier: MIT
#include "graph/descriptor_writer.h"

namespace penumbra {

DescriptorWriter::DescriptorWriter(const GraphDevice& device, size_t room) : device_(&device) {
    writes_.reserve(room);
    images_.reserve(room);
    buffers_.reserve(room);
    views_.reserve(room);
    handles_.reserve(room);
    structures_.reserve(room);
}

void DescriptorWriter::image(VkDescriptorSet set, const PlanBinding& b, const VkDescriptorImageInfo& info) {
    write(set, b).pImageInfo = &images_.emplace_back(info);
}

void DescriptorWriter::buffer(VkDescriptorSet set, const PlanBinding& b, const VkDescriptorBufferInfo& info) {
    write(set, b).pBufferInfo = &buffers_.emplace_back(info);
}

void DescriptorWriter::texels(VkDescriptorSet set, const PlanBinding& b, VkBufferView view) {
    write(set, b).pTexelBufferView = &views_.emplace_back(view);
}

void DescriptorWriter::structure(VkDescriptorSet set, const PlanBinding& b,
                                 VkAccelerationStructureKHR handle) {
    VkWriteDescriptorSetAccelerationStructureKHR structure{
        VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR};
    structure.accelerationStructureCount = 1;
    structure.pAccelerationStructures = &handles_.emplace_back(handle);
    write(set, b).pNext = &structures_.emplace_back(structure);
}

VkWriteDescriptorSet& DescriptorWriter::write(VkDescriptorSet set, const PlanBinding& b) {
    VkWriteDescriptorSet w{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    w.dstSet = set;
    w.dstBinding = b.binding;
    w.descriptorCount = 1;
    w.descriptorType = b.type;
    return writes_.emplace_back(w);
}

void DescriptorWriter::flush() {
    device_->vk().vkUpdateDescriptorSets(device_->get(), static_cast<uint32_t>(writes_.size()),
                                         writes_.data(), 0, nullptr);
    writes_.clear();
    images_.clear();
    buffers_.clear();
    views_.clear();
    handles_.clear();
    structures_.clear();
}

}  // namespace penumbra
