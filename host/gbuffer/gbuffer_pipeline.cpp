// SPDX-License-Identifier: MIT
// Vertices, formats and depth test of the G-buffer's pipeline.
#include "host/gbuffer/gbuffer_pipeline.h"

#include <cstddef>

#include "host/device/raster_pipeline.h"
#include "host/device/shader_module.h"
#include "host/scene/geometry.h"

namespace penumbra {

Owned<VkPipeline> make_gbuffer_pipeline(const Device& device, VkPipelineLayout layout, VkExtent2D area,
                                        DrawnAs as, bool materials) {
    const VkBool32 constants[] = {as.alpha_tested, as.textured};
    const VkSpecializationMapEntry places[] = {{0, 0, sizeof(VkBool32)},
                                               {1, sizeof(VkBool32), sizeof(VkBool32)}};
    const VkSpecializationInfo specialization{2, places, sizeof(constants), constants};
    // The second binding holds the previous frame's vertices: the same ones of what does not deform.
    const VkVertexInputBindingDescription bindings[] = {
        {0, sizeof(RasterVertex), VK_VERTEX_INPUT_RATE_VERTEX},
        {1, sizeof(RasterVertex), VK_VERTEX_INPUT_RATE_VERTEX}};
    const VkVertexInputAttributeDescription attributes[] = {
        {0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(RasterVertex, position)},
        {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(RasterVertex, winding_normal)},
        {2, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(RasterVertex, uv)},
        {3, 0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(RasterVertex, color)},
        {4, 1, VK_FORMAT_R32G32B32_SFLOAT, offsetof(RasterVertex, position)}};
    RasterPipeline pipeline;
    pipeline.vertex = host_shader("gbuffer.vert");
    pipeline.fragment = host_shader(materials ? "gbuffer_materials.frag" : "gbuffer.frag");
    pipeline.fragment_constants = &specialization;
    pipeline.input.vertexBindingDescriptionCount = 2;
    pipeline.input.pVertexBindingDescriptions = bindings;
    pipeline.input.vertexAttributeDescriptionCount = 5;
    pipeline.input.pVertexAttributeDescriptions = attributes;
    pipeline.layout = layout;
    pipeline.area = area;
    pipeline.colors = std::span(gbuffer_color_formats)
                          .first(materials ? gbuffer_color_formats.size() : gbuffer_colors_without_materials);
    pipeline.depth = gbuffer_test_format;
    pipeline.passes = VK_COMPARE_OP_GREATER;  // reverse Z
    return make_raster_pipeline(device, pipeline, "G-buffer");
}

}  // namespace penumbra
