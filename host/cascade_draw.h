// SPDX-License-Identifier: MIT
// What drawing a cascade's map and its bounds share: the constants of their shaders, and a pipeline that
// draws triangles onto one layer.
#pragma once

#include <span>

#include "host/cascade_fit.h"
#include "host/device.h"

namespace penumbra {

// `Constants` of host/shaders/cascade.glsl.
struct CascadeConstants {
    glm::vec4 texels_from_metres[3];
    float size, depth_m, texel_m;
    int32_t layer;
    uint32_t triangle_count;
    float raster_margin;
};

// `origin`: of the triangles' coordinates.
CascadeConstants cascade_constants(const Device& device, const CascadeFit& fit, uint32_t layer,
                                   const glm::dvec3& origin, uint32_t triangle_count);

struct CascadePipeline {
    std::span<const uint32_t> vertex, fragment;  // SPIR-V; no fragment stage: none is needed
    VkPipelineLayout layout = VK_NULL_HANDLE;
    uint32_t size = 0;                     // texels along a side
    VkFormat color = VK_FORMAT_UNDEFINED;  // undefined: none
    VkFormat depth = VK_FORMAT_UNDEFINED;  // undefined: no depth test
    bool minimum = false;                  // blends by it
};
Owned<VkPipeline> make_cascade_pipeline(const Device& device, const CascadePipeline& description);

Owned<VkPipelineLayout> make_cascade_layout(const Device& device, VkDescriptorSetLayout set,
                                            VkShaderStageFlags stages);

// A set's layout, its pool and itself.
struct CascadeSet {
    Owned<VkDescriptorSetLayout> layout;
    Owned<VkDescriptorPool> pool;
    VkDescriptorSet set = VK_NULL_HANDLE;
};
CascadeSet make_cascade_set(const Device& device, std::span<const VkDescriptorSetLayoutBinding> bindings);

// An attachment that is cleared, or, without a value, written all over.
VkRenderingAttachmentInfo cascade_attachment(VkImageView view, const VkClearValue* clear);

}  // namespace penumbra
