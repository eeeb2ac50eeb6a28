// SPDX-License-Identifier: MIT
// Per cascade one dispatch that sorts and bounds small triangles, then one rendering: what they gave, blended
// with the large ones.
#include "host/cascades/cascade_bounds.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/device/shader_module.h"

namespace penumbra {

namespace {

constexpr VkShaderStageFlags all_stages =
    VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;
constexpr uint32_t group = 64;              // of cascade_small.comp
constexpr uint32_t groups_per_row = 32768;  // below every device's limit
constexpr float no_surface_m = 1e30f;

void memory_barrier(VkCommandBuffer commands, VkPipelineStageFlags2 from, VkAccessFlags2 written,
                    VkPipelineStageFlags2 to, VkAccessFlags2 access) {
    VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
    barrier.srcStageMask = from;
    barrier.srcAccessMask = written;
    barrier.dstStageMask = to;
    barrier.dstAccessMask = access;
    VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    dependency.memoryBarrierCount = 1;
    dependency.pMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(commands, &dependency);
}

constexpr VkPipelineStageFlags2 drawing = VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT |
                                          VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT |
                                          VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;

}  // namespace

CascadeBounds::CascadeBounds(Device& device, const GpuImage& slopes)
    : device_(device), slopes_(slopes), size_(slopes.extent.width) {
    VkFormatProperties has{};
    vkGetPhysicalDeviceFormatProperties(device.physical(), format, &has);
    if (!(has.optimalTilingFeatures & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT))
        throw DeviceError(
            fmt::format("{} cannot blend rgba32f, which cascade_bounds need", device.info().name));
    small_ = make_device_buffer(device, VkDeviceSize{size_} * size_ * 2 * sizeof(uint32_t),
                                VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                "bounds of small triangles");
    VkSamplerCreateInfo sampler{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    VkSampler sampler_handle = VK_NULL_HANDLE;
    check(vkCreateSampler(device_.get(), &sampler, nullptr, &sampler_handle), "vkCreateSampler", "cascades");
    sampler_ = {device_.get(), sampler_handle};
    const auto binding = [](uint32_t at, VkDescriptorType type, VkShaderStageFlags stages) {
        return VkDescriptorSetLayoutBinding{at, type, 1, stages, nullptr};
    };
    constexpr VkShaderStageFlags vertex = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_COMPUTE_BIT;
    constexpr VkShaderStageFlags fragment = VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;
    const VkDescriptorSetLayoutBinding bindings[] = {
        binding(0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, vertex),
        binding(1, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, fragment),
        binding(2, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, fragment),
        binding(3, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, vertex)};
    bound_ = make_descriptor_sets(device, bindings, 1, "cascades");
    const VkDescriptorSetLayout sets[] = {bound_.layout.get()};
    layout_ = make_pipeline_layout(device, sets, all_stages, sizeof(CascadeConstants), "cascades");
    sort_ = make_compute_pipeline(device, host_shader("cascade_small.comp"), layout_.get(), "cascade bounds");
    RasterPipeline pipeline = cascade_pipeline(device, layout_.get(), size_);
    pipeline.vertex = host_shader("cascade_gather.vert");
    pipeline.fragment = host_shader("cascade_gather.frag");
    pipeline.colors = {&format, 1};
    gather_ = make_raster_pipeline(device, pipeline, "cascades");
    pipeline.vertex = host_shader("cascade_bounds.vert");
    pipeline.fragment = host_shader("cascade_bounds.frag");
    pipeline.minimum = true;
    draw_ = make_raster_pipeline(device, pipeline, "cascades");
}

void CascadeBounds::set_triangles(const GpuBuffer& triangles, uint32_t count) {
    triangle_count_ = count;
    const VkDeviceSize bytes =
        sizeof(VkDrawIndirectCommand) + VkDeviceSize{std::max(count, 1u)} * sizeof(uint32_t);
    if (large_.bytes < bytes)
        large_ = make_device_buffer(device_, bytes,
                                    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                                        VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                    "large triangles");
    write_buffer(device_, bound_.sets[0], 0, triangles);
    write_image(device_, bound_.sets[0], 1, sampler_.get(), slopes_.view.get());
    write_buffer(device_, bound_.sets[0], 2, small_);
    write_buffer(device_, bound_.sets[0], 3, large_);
}

// The buffers are one cascade's at a time.
void CascadeBounds::sort(VkCommandBuffer commands, const CascadeConstants& constants) const {
    memory_barrier(commands, drawing, 0, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                   VK_ACCESS_2_TRANSFER_WRITE_BIT);
    const VkDrawIndirectCommand nothing{0, 1, 0, 0};
    vkCmdUpdateBuffer(commands, large_.get(), 0, sizeof nothing, &nothing);
    vkCmdFillBuffer(commands, small_.get(), 0, VK_WHOLE_SIZE, ~0u);  // NONE of cascade_order.glsl
    memory_barrier(commands, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                   VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                   VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, sort_.get());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1, bound_.sets.data(),
                            0, nullptr);
    vkCmdPushConstants(commands, layout_.get(), all_stages, 0, sizeof constants, &constants);
    const uint32_t groups = (triangle_count_ + group - 1) / group;
    vkCmdDispatch(commands, std::min(groups, groups_per_row), (groups + groups_per_row - 1) / groups_per_row,
                  1);
    memory_barrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                   drawing, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT);
}

void CascadeBounds::record(VkCommandBuffer commands, const CascadeConstants* constants,
                           VkImageView target) const {
    const bool any = constants && triangle_count_ > 0;
    if (any) sort(commands, *constants);
    VkClearValue none{};
    for (float& channel : none.color.float32) channel = no_surface_m;
    const VkRenderingAttachmentInfo color = cascade_attachment(target, any ? nullptr : &none);
    VkRenderingInfo rendering{VK_STRUCTURE_TYPE_RENDERING_INFO};
    rendering.renderArea = {{0, 0}, {size_, size_}};
    rendering.layerCount = 1;
    rendering.colorAttachmentCount = 1;
    rendering.pColorAttachments = &color;
    vkCmdBeginRendering(commands, &rendering);
    if (any) {
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_.get(), 0, 1,
                                bound_.sets.data(), 0, nullptr);
        vkCmdPushConstants(commands, layout_.get(), all_stages, 0, sizeof *constants, constants);
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, gather_.get());
        vkCmdDraw(commands, 3, 1, 0, 0);
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, draw_.get());
        vkCmdDrawIndirect(commands, large_.get(), 0, 1, sizeof(VkDrawIndirectCommand));
    }
    vkCmdEndRendering(commands);
}

}  // namespace penumbra
