// SPDX-License-Identifier: MIT
// What plan.json says of Vulkan's objects, made: heaps, resources, pipelines, tables.
#pragma once

#include "host/device/gpu.h"
#include "tests/gpu_test.h"
#include "tests/plan_words.h"

namespace penumbra::test {

inline constexpr VkImageSubresourceRange whole{VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0,
                                               VK_REMAINING_ARRAY_LAYERS};

struct Instance {
    Owned<VkImage> image;
    std::vector<Owned<VkImageView>> views;  // the whole, then each level
    Owned<VkBuffer> buffer;
    Owned<VkBufferView> texels;
};

struct Pass {
    Owned<VkDescriptorSetLayout> layouts[2];
    Owned<VkPipelineLayout> layout;
    Owned<VkPipeline> pipeline;
};

struct PlanObjects {
    Json plan;
    std::vector<Owned<VkDeviceMemory>> heaps;
    std::vector<std::vector<Instance>> resources;  // by parity; what is kept has one
    std::vector<Pass> passes;
    std::vector<GpuImage> tables;
    Owned<VkSampler> nearest, linear;
    Owned<VkDescriptorPool> pool;
    GpuBuffer block, counters, nothing;

    VkDevice device() const { return gpu().get(); }

    explicit PlanObjects(const std::filesystem::path& folder);
    Owned<VkDeviceMemory> make_heap(const Json& heap) const;
    Owned<VkImageView> view_of(const Json& r, VkImage image, uint32_t level, uint32_t levels) const;
    Instance make_resource(const Json& r, size_t p) const;
    Owned<VkBufferView> texels_of(VkBuffer buffer, const std::string& format) const;
    Owned<VkSampler> make_sampler(VkFilter filter) const;
    Pass make_pass(const Json& pass, const std::filesystem::path& folder) const;
};

}  // namespace penumbra::test
