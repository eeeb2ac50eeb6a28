// SPDX-License-Identifier: MIT
// What drawing a cascade's map and its bounds share: the constants of their shaders, and a pipeline that
// draws triangles onto one layer.
#pragma once

#include "host/cascades/cascade_fit.h"
#include "host/device/raster_pipeline.h"

namespace penumbra {

// `Constants` of host/cascades/cascade.glsl.
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

// Onto a whole layer; shaders and formats are the caller's. Depth is clamped where the device can, since the
// depth range holds the whole scene only up to rounding.
RasterPipeline cascade_pipeline(const Device& device, VkPipelineLayout layout, uint32_t size);

// An attachment that is cleared, or, without a value, written all over.
VkRenderingAttachmentInfo cascade_attachment(VkImageView view, const VkClearValue* clear);

}  // namespace penumbra
