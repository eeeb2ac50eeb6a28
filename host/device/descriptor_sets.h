// SPDX-License-Identifier: MIT
// What the host's own pipelines bind: descriptor sets of one layout with their pool, and the pipeline's
// layout. The graph's passes have theirs from their declarations (penumbra/program.h).
#pragma once

#include <span>
#include <vector>

#include "host/device/gpu.h"

namespace penumbra {

struct DescriptorSets {
    Owned<VkDescriptorSetLayout> layout;
    Owned<VkDescriptorPool> pool;  // owns the sets
    std::vector<VkDescriptorSet> sets;
};

// `what`: for errors.
Owned<VkDescriptorSetLayout> make_set_layout(const Device& device,
                                             std::span<const VkDescriptorSetLayoutBinding> bindings,
                                             const char* what);
// `count` sets, at least one, nothing written to any yet.
DescriptorSets make_descriptor_sets(const Device& device,
                                    std::span<const VkDescriptorSetLayoutBinding> bindings, uint32_t count,
                                    const char* what);

// A whole buffer, or an image in SHADER_READ_ONLY_OPTIMAL, for a binding of one descriptor.
void write_buffer(const Device& device, VkDescriptorSet set, uint32_t binding, const GpuBuffer& buffer);
// So much of a uniform buffer, from an offset that is given when the set is bound.
void write_part(const Device& device, VkDescriptorSet set, uint32_t binding, const GpuBuffer& buffer,
                VkDeviceSize bytes);
void write_image(const Device& device, VkDescriptorSet set, uint32_t binding, VkSampler sampler,
                 VkImageView view);

// `constant_bytes` of push constants, which `stages` see; 0: there are none.
Owned<VkPipelineLayout> make_pipeline_layout(const Device& device,
                                             std::span<const VkDescriptorSetLayout> sets,
                                             VkShaderStageFlags stages, uint32_t constant_bytes,
                                             const char* what);

}  // namespace penumbra
