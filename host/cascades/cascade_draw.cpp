// SPDX-License-Identifier: MIT
#include "host/cascades/cascade_draw.h"

#include <cmath>

namespace penumbra {

CascadeConstants cascade_constants(const Device& device, const CascadeFit& fit, uint32_t layer,
                                   const glm::dvec3& origin, uint32_t triangle_count) {
    const glm::dmat4x3 map = texels_from_metres(fit, layer, origin);
    CascadeConstants constants{};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
            constants.texels_from_metres[row][column] = static_cast<float>(map[column][row]);
    constants.size = static_cast<float>(fit.size);
    constants.depth_m = static_cast<float>(fit.depth_m);
    constants.texel_m = static_cast<float>(fit.areas[layer].texel_m);
    constants.layer = static_cast<int32_t>(layer);
    constants.triangle_count = triangle_count;
    // Vertices are moved to a grid, once by clipping and once by the rasteriser; the rest is for rounding.
    constants.raster_margin = static_cast<float>(
        std::ldexp(2.0, -static_cast<int>(device.limits().subPixelPrecisionBits)) + 1.0 / 1024);
    return constants;
}

VkRenderingAttachmentInfo cascade_attachment(VkImageView view, const VkClearValue* clear) {
    VkRenderingAttachmentInfo info{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    info.imageView = view;
    info.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
    info.loadOp = clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    if (clear) info.clearValue = *clear;
    return info;
}

RasterPipeline cascade_pipeline(const Device& device, VkPipelineLayout layout, uint32_t size) {
    RasterPipeline result;
    result.layout = layout;
    result.area = {size, size};
    result.depth_clamp = device.caps().depth_clamp;
    return result;
}

}  // namespace penumbra
