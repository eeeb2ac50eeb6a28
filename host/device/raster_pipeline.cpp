// SPDX-License-Identifier: MIT
#include "host/device/raster_pipeline.h"

#include <vector>

#include "host/device/shader_module.h"

namespace penumbra {

Owned<VkPipeline> make_raster_pipeline(const Device& device, const RasterPipeline& description,
                                       const char* what) {
    const Owned<VkShaderModule> vertex = make_shader_module(device, description.vertex, what);
    Owned<VkShaderModule> fragment;
    std::vector<VkPipelineShaderStageCreateInfo> stages{
        shader_stage(VK_SHADER_STAGE_VERTEX_BIT, vertex.get())};
    if (!description.fragment.empty()) {
        fragment = make_shader_module(device, description.fragment, what);
        stages.push_back(shader_stage(VK_SHADER_STAGE_FRAGMENT_BIT, fragment.get()));
        stages.back().pSpecializationInfo = description.fragment_constants;
    }
    VkPipelineInputAssemblyStateCreateInfo assembly{
        VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    const VkExtent2D area = description.area;
    const VkViewport whole{0, 0, static_cast<float>(area.width), static_cast<float>(area.height), 0, 1};
    const VkRect2D scissor{{0, 0}, area};
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    viewport.pViewports = &whole;
    viewport.pScissors = &scissor;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.cullMode = VK_CULL_MODE_NONE;
    raster.lineWidth = 1;
    raster.depthClampEnable = description.depth_clamp;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = depth.depthWriteEnable = description.depth != VK_FORMAT_UNDEFINED;
    depth.depthCompareOp = description.passes;
    VkPipelineColorBlendAttachmentState color{};
    color.blendEnable = description.minimum;
    color.srcColorBlendFactor = color.dstColorBlendFactor = VK_BLEND_FACTOR_ONE;
    color.srcAlphaBlendFactor = color.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
    color.colorBlendOp = color.alphaBlendOp = VK_BLEND_OP_MIN;
    color.colorWriteMask = 0xf;
    const std::vector<VkPipelineColorBlendAttachmentState> colors(description.colors.size(), color);
    VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    blend.attachmentCount = static_cast<uint32_t>(colors.size());
    blend.pAttachments = colors.data();
    VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
    rendering.colorAttachmentCount = static_cast<uint32_t>(description.colors.size());
    rendering.pColorAttachmentFormats = description.colors.data();
    rendering.depthAttachmentFormat = description.depth;

    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering};
    info.stageCount = static_cast<uint32_t>(stages.size());
    info.pStages = stages.data();
    info.pVertexInputState = &description.input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blend;
    info.layout = description.layout;
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateGraphicsPipelines(device.get(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          "vkCreateGraphicsPipelines", what);
    return {device.get(), pipeline};
}

}  // namespace penumbra
