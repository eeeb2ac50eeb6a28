// SPDX-License-Identifier: MIT
// Fixed state of the G-buffer's pipeline, for dynamic rendering.
#include "host/gbuffer_pipeline.h"

#include <cstddef>

#include "gbuffer.frag.h"  // made by the build from shaders/gbuffer.{vert,frag}
#include "gbuffer.vert.h"
#include "host/geometry.h"
#include "host/shader_module.h"

namespace penumbra {

Owned<VkPipeline> make_gbuffer_pipeline(const Device& device, VkPipelineLayout layout, bool alpha_tested) {
    const Owned<VkShaderModule> vertex = make_shader_module(device, gbuffer_vert, "gbuffer.vert");
    const Owned<VkShaderModule> fragment = make_shader_module(device, gbuffer_frag, "gbuffer.frag");
    VkPipelineShaderStageCreateInfo stages[] = {shader_stage(VK_SHADER_STAGE_VERTEX_BIT, vertex.get()),
                                                shader_stage(VK_SHADER_STAGE_FRAGMENT_BIT, fragment.get())};
    const VkBool32 tested = alpha_tested;
    const VkSpecializationMapEntry constant{0, 0, sizeof(tested)};  // ALPHA_TESTED
    const VkSpecializationInfo specialization{1, &constant, sizeof(tested), &tested};
    stages[1].pSpecializationInfo = &specialization;

    const VkVertexInputBindingDescription binding{0, sizeof(RasterVertex), VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attributes[] = {
        {0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(RasterVertex, position)},
        {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(RasterVertex, winding_normal)},
        {2, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(RasterVertex, uv)}};
    VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    input.vertexBindingDescriptionCount = 1;
    input.pVertexBindingDescriptions = &binding;
    input.vertexAttributeDescriptionCount = 3;
    input.pVertexAttributeDescriptions = attributes;
    VkPipelineInputAssemblyStateCreateInfo assembly{
        VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = 1;
    viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.cullMode = VK_CULL_MODE_NONE;  // shadow rays meet both sides, so the eye does too
    raster.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = VK_TRUE;
    depth.depthWriteEnable = VK_TRUE;
    depth.depthCompareOp = VK_COMPARE_OP_GREATER;
    std::array<VkPipelineColorBlendAttachmentState, 3> blends{};
    for (auto& blend : blends) blend.colorWriteMask = 0xf;
    VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    blend.attachmentCount = 3;
    blend.pAttachments = blends.data();
    const VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
    dynamic.dynamicStateCount = 2;
    dynamic.pDynamicStates = dynamic_states;
    VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
    rendering.colorAttachmentCount = 3;
    rendering.pColorAttachmentFormats = gbuffer_color_formats.data();
    rendering.depthAttachmentFormat = gbuffer_depth_format;

    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering};
    info.stageCount = 2;
    info.pStages = stages;
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blend;
    info.pDynamicState = &dynamic;
    info.layout = layout;
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateGraphicsPipelines(device.get(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          "vkCreateGraphicsPipelines", "G-buffer");
    return {device.get(), pipeline};
}

}  // namespace penumbra
