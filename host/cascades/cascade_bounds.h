// SPDX-License-Identifier: MIT
// Draws a cascade's bounds: the least depth of any surface that touches a texel, and a plane below all of
// them. Triangles of a few texels, which are most of them, are bounded in a compute shader; the others are
// drawn as polygons that cover every texel they touch.
#pragma once

#include "host/cascades/cascade_draw.h"
#include "host/device/descriptor_sets.h"
#include "host/device/gpu.h"

namespace penumbra {

class CascadeBounds {
  public:
    static constexpr VkFormat format = VK_FORMAT_R32G32B32A32_SFLOAT;

    // `slopes`: an array of rg32f images, a layer per cascade, which outlives the bounds.
    CascadeBounds(Device& device, const GpuImage& slopes);

    // Nothing on the device may be reading what was there before.
    void set_triangles(const GpuBuffer& triangles, uint32_t count);

    // Onto a layer of the bounds that is in ATTACHMENT_OPTIMAL; the slopes are visible to compute and
    // fragment shaders. No constants: nothing is there.
    void record(VkCommandBuffer commands, const CascadeConstants* constants, VkImageView target) const;

  private:
    void sort(VkCommandBuffer commands, const CascadeConstants& constants) const;

    Device& device_;
    const GpuImage& slopes_;
    uint32_t size_, triangle_count_ = 0;
    GpuBuffer small_;  // two ordered integers per texel of one layer
    GpuBuffer large_;  // arguments of a draw, then the numbers of triangles
    Owned<VkSampler> sampler_;
    DescriptorSets bound_;
    Owned<VkPipelineLayout> layout_;
    Owned<VkPipeline> sort_, gather_, draw_;
};

}  // namespace penumbra
