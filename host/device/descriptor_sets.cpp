// SPDX-License-Identifier: MIT
#include "host/device/descriptor_sets.h"

namespace penumbra {

namespace {

void write(const Device& device, VkDescriptorSet set, uint32_t binding, VkDescriptorType type,
           const VkDescriptorBufferInfo* buffer, const VkDescriptorImageInfo* image) {
    VkWriteDescriptorSet info{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    info.dstSet = set;
    info.dstBinding = binding;
    info.descriptorCount = 1;
    info.descriptorType = type;
    info.pBufferInfo = buffer;
    info.pImageInfo = image;
    vkUpdateDescriptorSets(device.get(), 1, &info, 0, nullptr);
}

}  // namespace

Owned<VkDescriptorSetLayout> make_set_layout(const Device& device,
                                             std::span<const VkDescriptorSetLayoutBinding> bindings,
                                             const char* what) {
    VkDescriptorSetLayoutCreateInfo layout{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    layout.bindingCount = static_cast<uint32_t>(bindings.size());
    layout.pBindings = bindings.data();
    VkDescriptorSetLayout handle = VK_NULL_HANDLE;
    check(vkCreateDescriptorSetLayout(device.get(), &layout, nullptr, &handle), "vkCreateDescriptorSetLayout",
          what);
    return {device.get(), handle};
}

DescriptorSets make_descriptor_sets(const Device& device,
                                    std::span<const VkDescriptorSetLayoutBinding> bindings, uint32_t count,
                                    const char* what) {
    DescriptorSets result;
    result.layout = make_set_layout(device, bindings, what);

    std::vector<VkDescriptorPoolSize> sizes;
    for (const VkDescriptorSetLayoutBinding& binding : bindings)
        sizes.push_back({binding.descriptorType, binding.descriptorCount * count});
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.maxSets = count;
    pool.poolSizeCount = static_cast<uint32_t>(sizes.size());
    pool.pPoolSizes = sizes.data();
    VkDescriptorPool pool_handle = VK_NULL_HANDLE;
    check(vkCreateDescriptorPool(device.get(), &pool, nullptr, &pool_handle), "vkCreateDescriptorPool", what);
    result.pool = {device.get(), pool_handle};

    const std::vector<VkDescriptorSetLayout> layouts(count, result.layout.get());
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocate.descriptorPool = pool_handle;
    allocate.descriptorSetCount = count;
    allocate.pSetLayouts = layouts.data();
    result.sets.resize(count);
    check(vkAllocateDescriptorSets(device.get(), &allocate, result.sets.data()), "vkAllocateDescriptorSets",
          what);
    return result;
}

void write_buffer(const Device& device, VkDescriptorSet set, uint32_t binding, const GpuBuffer& buffer) {
    const VkDescriptorBufferInfo info{buffer.get(), 0, VK_WHOLE_SIZE};
    write(device, set, binding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, &info, nullptr);
}

void write_part(const Device& device, VkDescriptorSet set, uint32_t binding, const GpuBuffer& buffer,
                VkDeviceSize bytes) {
    const VkDescriptorBufferInfo info{buffer.get(), 0, bytes};
    write(device, set, binding, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, &info, nullptr);
}

void write_image(const Device& device, VkDescriptorSet set, uint32_t binding, VkSampler sampler,
                 VkImageView view) {
    const VkDescriptorImageInfo info{sampler, view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    write(device, set, binding, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, nullptr, &info);
}

Owned<VkPipelineLayout> make_pipeline_layout(const Device& device,
                                             std::span<const VkDescriptorSetLayout> sets,
                                             VkShaderStageFlags stages, uint32_t constant_bytes,
                                             const char* what) {
    const VkPushConstantRange constants{stages, 0, constant_bytes};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = static_cast<uint32_t>(sets.size());
    layout.pSetLayouts = sets.data();
    layout.pushConstantRangeCount = constant_bytes > 0 ? 1 : 0;
    layout.pPushConstantRanges = &constants;
    VkPipelineLayout handle = VK_NULL_HANDLE;
    check(vkCreatePipelineLayout(device.get(), &layout, nullptr, &handle), "vkCreatePipelineLayout", what);
    return {device.get(), handle};
}

}  // namespace penumbra
