// SPDX-License-Identifier: MIT
// Fixed state: no culling, since shadow rays meet both sides, and depth clamp where the device has it, since
// the depth range holds the whole scene only up to rounding.
#include "host/cascade_draw.h"

#include <cmath>

#include "host/shader_module.h"

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

Owned<VkPipelineLayout> make_cascade_layout(const Device& device, VkDescriptorSetLayout set,
                                            VkShaderStageFlags stages) {
    const VkPushConstantRange constants{stages, 0, sizeof(CascadeConstants)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &set;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &constants;
    VkPipelineLayout handle = VK_NULL_HANDLE;
    check(vkCreatePipelineLayout(device.get(), &layout, nullptr, &handle), "vkCreatePipelineLayout",
          "cascades");
    return {device.get(), handle};
}

CascadeSet make_cascade_set(const Device& device, std::span<const VkDescriptorSetLayoutBinding> bindings) {
    CascadeSet result;
    VkDescriptorSetLayoutCreateInfo layout{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    layout.bindingCount = static_cast<uint32_t>(bindings.size());
    layout.pBindings = bindings.data();
    VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
    check(vkCreateDescriptorSetLayout(device.get(), &layout, nullptr, &set_layout),
          "vkCreateDescriptorSetLayout", "cascades");
    result.layout = {device.get(), set_layout};
    std::vector<VkDescriptorPoolSize> sizes;
    for (const VkDescriptorSetLayoutBinding& binding : bindings)
        sizes.push_back({binding.descriptorType, binding.descriptorCount});
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.maxSets = 1;
    pool.poolSizeCount = static_cast<uint32_t>(sizes.size());
    pool.pPoolSizes = sizes.data();
    VkDescriptorPool pool_handle = VK_NULL_HANDLE;
    check(vkCreateDescriptorPool(device.get(), &pool, nullptr, &pool_handle), "vkCreateDescriptorPool",
          "cascades");
    result.pool = {device.get(), pool_handle};
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocate.descriptorPool = pool_handle;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &set_layout;
    check(vkAllocateDescriptorSets(device.get(), &allocate, &result.set), "vkAllocateDescriptorSets",
          "cascades");
    return result;
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

Owned<VkPipeline> make_cascade_pipeline(const Device& device, const CascadePipeline& description) {
    const Owned<VkShaderModule> vertex = make_shader_module(device, description.vertex, "cascades");
    Owned<VkShaderModule> fragment;
    std::vector<VkPipelineShaderStageCreateInfo> stages{
        shader_stage(VK_SHADER_STAGE_VERTEX_BIT, vertex.get())};
    if (!description.fragment.empty()) {
        fragment = make_shader_module(device, description.fragment, "cascades");
        stages.push_back(shader_stage(VK_SHADER_STAGE_FRAGMENT_BIT, fragment.get()));
    }
    const VkPipelineVertexInputStateCreateInfo input{
        VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly{
        VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    const float side = static_cast<float>(description.size);
    const VkViewport area{0, 0, side, side, 0, 1};
    const VkRect2D scissor{{0, 0}, {description.size, description.size}};
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    viewport.pViewports = &area;
    viewport.pScissors = &scissor;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.cullMode = VK_CULL_MODE_NONE;
    raster.lineWidth = 1;
    raster.depthClampEnable = device.caps().depth_clamp;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = depth.depthWriteEnable = description.depth != VK_FORMAT_UNDEFINED;
    depth.depthCompareOp = VK_COMPARE_OP_LESS;
    VkPipelineColorBlendAttachmentState minimum{};
    minimum.blendEnable = description.minimum;
    minimum.srcColorBlendFactor = minimum.dstColorBlendFactor = VK_BLEND_FACTOR_ONE;
    minimum.srcAlphaBlendFactor = minimum.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
    minimum.colorBlendOp = minimum.alphaBlendOp = VK_BLEND_OP_MIN;
    minimum.colorWriteMask = 0xf;
    const uint32_t colors = description.color != VK_FORMAT_UNDEFINED ? 1 : 0;
    VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    blend.attachmentCount = colors;
    blend.pAttachments = &minimum;
    VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
    rendering.colorAttachmentCount = colors;
    rendering.pColorAttachmentFormats = &description.color;
    rendering.depthAttachmentFormat = description.depth;

    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering};
    info.stageCount = static_cast<uint32_t>(stages.size());
    info.pStages = stages.data();
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blend;
    info.layout = description.layout;
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateGraphicsPipelines(device.get(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          "vkCreateGraphicsPipelines", "cascades");
    return {device.get(), pipeline};
}

}  // namespace penumbra
