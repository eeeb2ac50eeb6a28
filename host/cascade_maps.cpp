// SPDX-License-Identifier: MIT
// Two draws per cascade: the map with its slopes, then the bounds, which are made for those slopes.
#include "host/cascade_maps.h"

#include <fmt/format.h>

#include <stdexcept>

#include "cascade_bounds.frag.h"  // made by the build from shaders/cascade_*
#include "cascade_bounds.vert.h"
#include "cascade_map.frag.h"
#include "cascade_map.vert.h"
#include "host/shader_module.h"

namespace penumbra {

namespace {

constexpr VkFormat slopes_format = VK_FORMAT_R16G16_SFLOAT;
constexpr float no_surface_m = 1e30f;
constexpr VkShaderStageFlags both_stages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
constexpr VkPipelineStageFlags2 depth_stages =
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;

// `Constants` of shaders/cascade.glsl.
struct CascadeConstants {
    glm::vec4 texels_from_metres[3];
    float size, depth_m, texel_m;
    int32_t layer;
};

bool same(const CascadeFit& a, const CascadeFit& b) {
    return a.light.u == b.light.u && a.light.v == b.light.v && a.light.away == b.light.away &&
           a.size == b.size && a.count == b.count && a.areas == b.areas && a.near_m == b.near_m &&
           a.depth_m == b.depth_m;
}

VkImageMemoryBarrier2 barrier(const GpuImage& image, VkImageLayout from, VkImageLayout to) {
    const bool depth = is_depth(image.format);
    VkImageMemoryBarrier2 result{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    result.oldLayout = from;
    result.newLayout = to;
    result.srcQueueFamilyIndex = result.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    result.image = image.get();
    result.subresourceRange = {
        VkImageAspectFlags(depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT), 0, 1, 0,
        image.layers};
    return result;
}

// Old contents are dropped once everything before has read them.
VkImageMemoryBarrier2 to_attachment(const GpuImage& image) {
    const bool depth = is_depth(image.format);
    VkImageMemoryBarrier2 result =
        barrier(image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL);
    result.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    result.dstStageMask = depth ? depth_stages : VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
    result.dstAccessMask =
        depth ? VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT
              : VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
    return result;
}

VkImageMemoryBarrier2 to_readers(const GpuImage& image) {
    const bool depth = is_depth(image.format);
    VkImageMemoryBarrier2 result =
        barrier(image, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    result.srcStageMask = depth ? depth_stages : VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
    result.srcAccessMask =
        depth ? VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT : VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
    result.dstStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT |
                          VK_PIPELINE_STAGE_2_COPY_BIT;
    result.dstAccessMask = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_TRANSFER_READ_BIT;
    return result;
}

void record_barriers(VkCommandBuffer commands, std::span<const VkImageMemoryBarrier2> list) {
    VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    dependency.imageMemoryBarrierCount = static_cast<uint32_t>(list.size());
    dependency.pImageMemoryBarriers = list.data();
    vkCmdPipelineBarrier2(commands, &dependency);
}

VkRenderingAttachmentInfo cleared(VkImageView view, const VkClearValue& value) {
    VkRenderingAttachmentInfo info{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    info.imageView = view;
    info.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
    info.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    info.clearValue = value;
    return info;
}

}  // namespace

CascadeMaps::CascadeMaps(Device& device, const Scene& scene, uint32_t size, uint32_t layers, bool with_bounds)
    : device_(device), scene_(scene), with_bounds_(with_bounds), layers_(layers) {
    constexpr VkImageUsageFlags read = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    constexpr VkImageUsageFlags color = read | VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    const VkExtent2D extent{size, size};
    maps_ = make_layered_image(device, maps_format, extent, layers,
                               read | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, "cascade_maps");
    if (with_bounds) {
        VkFormatProperties has{};
        vkGetPhysicalDeviceFormatProperties(device.physical(), bounds_format, &has);
        if (!(has.optimalTilingFeatures & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT))
            throw DeviceError(
                fmt::format("{} cannot blend rgba32f, which cascade_bounds need", device.info().name));
        slopes_ = make_layered_image(device, slopes_format, extent, layers, color, "cascade slopes");
        bounds_ = make_layered_image(device, bounds_format, extent, layers, color, "cascade_bounds");
    }
    for (uint32_t i = 0; i < layers; ++i) {
        layers_[i].map = make_layer_view(device, maps_, i);
        if (!with_bounds) continue;
        layers_[i].slopes = make_layer_view(device, slopes_, i);
        layers_[i].bounds = make_layer_view(device, bounds_, i);
    }
    make_descriptors();
    update(0);
    make_pipelines();
}

void CascadeMaps::update(double frame) {
    const std::vector<Triangle> triangles = scene_.triangles(frame);
    triangle_count_ = static_cast<uint32_t>(triangles.size());
    if (triangles.size() > (1u << 29) ||
        triangles.size() * sizeof(Triangle) > device_.limits().maxStorageBufferRange)
        throw DeviceError(fmt::format("cascades of {} triangles need a larger storage buffer than {} has",
                                      triangles.size(), device_.info().name));
    triangles_ = upload_buffer(device_, std::as_bytes(std::span(triangles)),
                               VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "cascade triangles");
    write_descriptors();
    drawn_.reset();
}

void CascadeMaps::make_descriptors() {
    VkSamplerCreateInfo sampler{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    VkSampler sampler_handle = VK_NULL_HANDLE;
    check(vkCreateSampler(device_.get(), &sampler, nullptr, &sampler_handle), "vkCreateSampler", "cascades");
    sampler_ = {device_.get(), sampler_handle};

    std::vector<VkDescriptorSetLayoutBinding> bindings{
        {0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_VERTEX_BIT, nullptr}};
    std::vector<VkDescriptorPoolSize> sizes{{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1}};
    if (with_bounds_) {
        bindings.push_back(
            {1, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr});
        sizes.push_back({VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1});
    }
    VkDescriptorSetLayoutCreateInfo layout{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    layout.bindingCount = static_cast<uint32_t>(bindings.size());
    layout.pBindings = bindings.data();
    VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
    check(vkCreateDescriptorSetLayout(device_.get(), &layout, nullptr, &set_layout),
          "vkCreateDescriptorSetLayout", "cascades");
    set_layout_ = {device_.get(), set_layout};
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.maxSets = 1;
    pool.poolSizeCount = static_cast<uint32_t>(sizes.size());
    pool.pPoolSizes = sizes.data();
    VkDescriptorPool pool_handle = VK_NULL_HANDLE;
    check(vkCreateDescriptorPool(device_.get(), &pool, nullptr, &pool_handle), "vkCreateDescriptorPool",
          "cascades");
    pool_ = {device_.get(), pool_handle};
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocate.descriptorPool = pool_handle;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &set_layout;
    check(vkAllocateDescriptorSets(device_.get(), &allocate, &set_), "vkAllocateDescriptorSets", "cascades");
}

void CascadeMaps::write_descriptors() {
    const VkDescriptorBufferInfo buffer{triangles_.get(), 0, VK_WHOLE_SIZE};
    VkWriteDescriptorSet writes[2] = {{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET},
                                      {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET}};
    writes[0].dstSet = writes[1].dstSet = set_;
    writes[0].descriptorCount = writes[1].descriptorCount = 1;
    writes[0].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    writes[0].pBufferInfo = &buffer;
    const VkDescriptorImageInfo image{sampler_.get(), slopes_.view.get(),
                                      VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    writes[1].dstBinding = 1;
    writes[1].descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    writes[1].pImageInfo = &image;
    vkUpdateDescriptorSets(device_.get(), with_bounds_ ? 2 : 1, writes, 0, nullptr);
}

void CascadeMaps::make_pipelines() {
    const VkPushConstantRange constants{both_stages, 0, sizeof(CascadeConstants)};
    const VkDescriptorSetLayout set = set_layout_.get();
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &set;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &constants;
    VkPipelineLayout handle = VK_NULL_HANDLE;
    check(vkCreatePipelineLayout(device_.get(), &layout, nullptr, &handle), "vkCreatePipelineLayout",
          "cascades");
    layout_ = {device_.get(), handle};
    map_pipeline_ = make_pipeline(false);
    if (with_bounds_) bounds_pipeline_ = make_pipeline(true);
}

// `bounds`: the second draw, which blends; otherwise the first, without a fragment stage where nobody asks
// for slopes.
Owned<VkPipeline> CascadeMaps::make_pipeline(bool bounds) const {
    const Owned<VkShaderModule> vertex = make_shader_module(
        device_, bounds ? std::span<const uint32_t>(cascade_bounds_vert) : cascade_map_vert, "cascades");
    const Owned<VkShaderModule> fragment = make_shader_module(
        device_, bounds ? std::span<const uint32_t>(cascade_bounds_frag) : cascade_map_frag, "cascades");
    const VkPipelineShaderStageCreateInfo stages[] = {
        shader_stage(VK_SHADER_STAGE_VERTEX_BIT, vertex.get()),
        shader_stage(VK_SHADER_STAGE_FRAGMENT_BIT, fragment.get())};
    const VkPipelineVertexInputStateCreateInfo input{
        VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly{
        VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    const float side = static_cast<float>(maps_.extent.width);
    const VkViewport area{0, 0, side, side, 0, 1};
    const VkRect2D scissor{{0, 0}, maps_.extent};
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    viewport.pViewports = &area;
    viewport.pScissors = &scissor;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.cullMode = VK_CULL_MODE_NONE;  // shadow rays meet both sides
    raster.lineWidth = 1;
    // The depth range holds the whole scene up to rounding; where the device can, the rest is clamped.
    raster.depthClampEnable = device_.caps().depth_clamp;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = depth.depthWriteEnable = !bounds;
    depth.depthCompareOp = VK_COMPARE_OP_LESS;
    VkPipelineColorBlendAttachmentState minimum{};
    minimum.blendEnable = bounds;
    minimum.srcColorBlendFactor = minimum.dstColorBlendFactor = VK_BLEND_FACTOR_ONE;
    minimum.srcAlphaBlendFactor = minimum.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
    minimum.colorBlendOp = minimum.alphaBlendOp = VK_BLEND_OP_MIN;
    minimum.colorWriteMask = 0xf;
    VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    blend.attachmentCount = with_bounds_ ? 1 : 0;
    blend.pAttachments = &minimum;
    const VkFormat color_format = bounds ? bounds_format : slopes_format;
    VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
    rendering.colorAttachmentCount = with_bounds_ ? 1 : 0;
    rendering.pColorAttachmentFormats = &color_format;
    rendering.depthAttachmentFormat = bounds ? VK_FORMAT_UNDEFINED : maps_format;

    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering};
    info.stageCount = with_bounds_ ? 2 : 1;
    info.pStages = stages;
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blend;
    info.layout = layout_.get();
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateGraphicsPipelines(device_.get(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          "vkCreateGraphicsPipelines", "cascades");
    return {device_.get(), pipeline};
}

void CascadeMaps::draw(VkCommandBuffer commands, const CascadeFit& fit, uint32_t layer, bool bounds) const {
    VkClearValue far_end{}, level{}, none{};
    far_end.depthStencil = {1, 0};
    for (float& channel : none.color.float32) channel = no_surface_m;
    const Layer& target = layers_[layer];
    const VkRenderingAttachmentInfo depth = cleared(target.map.get(), far_end);
    const VkRenderingAttachmentInfo color =
        bounds ? cleared(target.bounds.get(), none) : cleared(target.slopes.get(), level);
    VkRenderingInfo rendering{VK_STRUCTURE_TYPE_RENDERING_INFO};
    rendering.renderArea = {{0, 0}, maps_.extent};
    rendering.layerCount = 1;
    rendering.colorAttachmentCount = with_bounds_ ? 1 : 0;
    rendering.pColorAttachments = &color;
    rendering.pDepthAttachment = bounds ? nullptr : &depth;
    vkCmdBeginRendering(commands, &rendering);
    if (triangle_count_ > 0 && layer < fit.count) {
        const glm::dmat4x3 map = texels_from_metres(fit, layer, scene_.bvh_origin());
        CascadeConstants constants{};
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 4; ++column)
                constants.texels_from_metres[row][column] = static_cast<float>(map[column][row]);
        constants.size = static_cast<float>(fit.size);
        constants.depth_m = static_cast<float>(fit.depth_m);
        constants.texel_m = static_cast<float>(fit.areas[layer].texel_m);
        constants.layer = static_cast<int32_t>(layer);
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS,
                          bounds ? bounds_pipeline_.get() : map_pipeline_.get());
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_.get(), 0, 1, &set_, 0,
                                nullptr);
        vkCmdPushConstants(commands, layout_.get(), both_stages, 0, sizeof constants, &constants);
        vkCmdDraw(commands, (bounds ? 6 : 3) * triangle_count_, 1, 0, 0);
    }
    vkCmdEndRendering(commands);
}

bool CascadeMaps::record(VkCommandBuffer commands, const CascadeFit& fit) {
    if (fit.count > layers_.size() || fit.size != maps_.extent.width)
        throw std::invalid_argument("CascadeMaps::record: a fit for other maps");
    if (drawn_ && same(*drawn_, fit)) return false;
    drawn_ = fit;
    std::vector<VkImageMemoryBarrier2> list{to_attachment(maps_)};
    if (with_bounds_) list.push_back(to_attachment(slopes_));
    record_barriers(commands, list);
    for (uint32_t i = 0; i < layers_.size(); ++i) draw(commands, fit, i, false);
    list = {to_readers(maps_)};
    if (with_bounds_) {
        list.push_back(to_readers(slopes_));
        list.push_back(to_attachment(bounds_));
    }
    record_barriers(commands, list);
    if (!with_bounds_) return true;
    for (uint32_t i = 0; i < layers_.size(); ++i) draw(commands, fit, i, true);
    const VkImageMemoryBarrier2 done[] = {to_readers(bounds_)};
    record_barriers(commands, done);
    return true;
}

}  // namespace penumbra
