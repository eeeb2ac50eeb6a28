// SPDX-License-Identifier: MIT
// Per cascade the map with its slopes, then the bounds, which are made for those slopes.
#include "host/cascades/cascade_maps.h"

#include <fmt/format.h>

#include <stdexcept>

#include "host/device/shader_module.h"

namespace penumbra {

namespace {

constexpr VkFormat slopes_format = VK_FORMAT_R32G32_SFLOAT;
constexpr VkShaderStageFlags both_stages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
constexpr uint32_t most_triangles = 1u << 28;  // 15 vertices of each can be counted
constexpr VkPipelineStageFlags2 depth_stages =
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;

CascadeView view_of(const CascadeFit& fit, uint32_t layer) {
    if (layer >= fit.count) return {};
    return {fit.light.u, fit.light.v, fit.light.away, fit.areas[layer], fit.near_m, fit.depth_m, false};
}

VkImageMemoryBarrier2 barrier(const GpuImage& image, uint32_t layer, VkImageLayout from, VkImageLayout to) {
    const bool depth = is_depth(image.format);
    VkImageMemoryBarrier2 result{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    result.oldLayout = from;
    result.newLayout = to;
    result.srcQueueFamilyIndex = result.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    result.image = image.get();
    result.subresourceRange = {
        VkImageAspectFlags(depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT), 0, 1, layer, 1};
    return result;
}

// Old contents are dropped once everything before has read them.
VkImageMemoryBarrier2 to_attachment(const GpuImage& image, uint32_t layer) {
    const bool depth = is_depth(image.format);
    VkImageMemoryBarrier2 result =
        barrier(image, layer, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL);
    result.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    result.dstStageMask = depth ? depth_stages : VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
    result.dstAccessMask =
        depth ? VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT
              : VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
    return result;
}

VkImageMemoryBarrier2 to_readers(const GpuImage& image, uint32_t layer) {
    const bool depth = is_depth(image.format);
    VkImageMemoryBarrier2 result =
        barrier(image, layer, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
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

}  // namespace

CascadeMaps::CascadeMaps(Device& device, const Scene& scene, uint32_t size, uint32_t layers, bool with_bounds)
    : device_(device), scene_(scene), with_bounds_(with_bounds), layers_(layers) {
    constexpr VkImageUsageFlags read = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    constexpr VkImageUsageFlags color = read | VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    const VkExtent2D extent{size, size};
    maps_ = make_layered_image(device, maps_format, extent, layers,
                               read | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, "cascade_maps");
    if (with_bounds) {
        slopes_ = make_layered_image(device, slopes_format, extent, layers, color, "cascade slopes");
        bounds_drawing_.emplace(device, slopes_);
        bounds_ = make_layered_image(device, bounds_format, extent, layers, color, "cascade_bounds");
    }
    for (uint32_t i = 0; i < layers; ++i) {
        layers_[i].map = make_layer_view(device, maps_, i);
        if (!with_bounds) continue;
        layers_[i].slopes = make_layer_view(device, slopes_, i);
        layers_[i].bounds = make_layer_view(device, bounds_, i);
    }
    const VkDescriptorSetLayoutBinding triangles{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1,
                                                 VK_SHADER_STAGE_VERTEX_BIT, nullptr};
    bound_ = make_descriptor_sets(device, {&triangles, 1}, 1, "cascades");
    const VkDescriptorSetLayout sets[] = {bound_.layout.get()};
    layout_ = make_pipeline_layout(device, sets, both_stages, sizeof(CascadeConstants), "cascades");
    // Without a fragment stage where nobody asks for slopes.
    RasterPipeline pipeline = cascade_pipeline(device, layout_.get(), size);
    pipeline.vertex = host_shader("cascade_map.vert");
    pipeline.depth = maps_format;
    if (with_bounds) {
        pipeline.fragment = host_shader("cascade_map.frag");
        pipeline.colors = {&slopes_format, 1};
    }
    pipeline_ = make_raster_pipeline(device, pipeline, "cascades");
    update(0);
}

void CascadeMaps::update(double frame) {
    std::vector<Triangle> triangles = scene_.triangles(frame);
    if (scene_.has_translucent()) std::erase_if(triangles, [](const Triangle& t) { return !usable(t); });
    triangle_count_ = static_cast<uint32_t>(triangles.size());
    if (triangles.size() > most_triangles ||
        triangles.size() * sizeof(Triangle) > device_.limits().maxStorageBufferRange)
        throw DeviceError(fmt::format("cascades of {} triangles need a larger storage buffer than {} has",
                                      triangles.size(), device_.info().name));
    triangles_ = upload_buffer(device_, std::as_bytes(std::span(triangles)),
                               VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "cascade triangles");
    write_buffer(device_, bound_.sets[0], 0, triangles_);
    if (bounds_drawing_) bounds_drawing_->set_triangles(triangles_, triangle_count_);
    for (Layer& layer : layers_) layer.drawn.reset();
}

// The map, and its slopes where there are any.
void CascadeMaps::draw(VkCommandBuffer commands, const CascadeFit& fit, uint32_t layer) const {
    VkClearValue far_end{}, level{};
    far_end.depthStencil = {1, 0};
    const Layer& target = layers_[layer];
    const VkRenderingAttachmentInfo depth = cascade_attachment(target.map.get(), &far_end);
    const VkRenderingAttachmentInfo color = cascade_attachment(target.slopes.get(), &level);
    VkRenderingInfo rendering{VK_STRUCTURE_TYPE_RENDERING_INFO};
    rendering.renderArea = {{0, 0}, maps_.extent};
    rendering.layerCount = 1;
    rendering.colorAttachmentCount = with_bounds_ ? 1 : 0;
    rendering.pColorAttachments = &color;
    rendering.pDepthAttachment = &depth;
    vkCmdBeginRendering(commands, &rendering);
    if (triangle_count_ > 0 && layer < fit.count) {
        const CascadeConstants constants =
            cascade_constants(device_, fit, layer, scene_.bvh_origin(), triangle_count_);
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_.get());
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_.get(), 0, 1,
                                bound_.sets.data(), 0, nullptr);
        vkCmdPushConstants(commands, layout_.get(), both_stages, 0, sizeof constants, &constants);
        vkCmdDraw(commands, 3 * triangle_count_, 1, 0, 0);
    }
    vkCmdEndRendering(commands);
}

uint32_t CascadeMaps::record(VkCommandBuffer commands, const CascadeFit& fit) {
    if (fit.count > layers_.size() || fit.size != maps_.extent.width)
        throw std::invalid_argument("CascadeMaps::record: a fit for other maps");
    std::vector<uint32_t> moved;
    for (uint32_t i = 0; i < layers_.size(); ++i) {
        const CascadeView view = view_of(fit, i);
        if (layers_[i].drawn == view) continue;
        layers_[i].drawn = view;
        moved.push_back(i);
    }
    if (moved.empty()) return 0;
    std::vector<VkImageMemoryBarrier2> before, between, after;
    for (const uint32_t i : moved) {
        before.push_back(to_attachment(maps_, i));
        between.push_back(to_readers(maps_, i));
        if (!with_bounds_) continue;
        before.push_back(to_attachment(slopes_, i));
        between.push_back(to_readers(slopes_, i));
        between.push_back(to_attachment(bounds_, i));
        after.push_back(to_readers(bounds_, i));
    }
    record_barriers(commands, before);
    for (const uint32_t i : moved) draw(commands, fit, i);
    record_barriers(commands, between);
    if (!with_bounds_) return static_cast<uint32_t>(moved.size());
    for (const uint32_t i : moved) {
        CascadeConstants constants{};
        if (i < fit.count)
            constants = cascade_constants(device_, fit, i, scene_.bvh_origin(), triangle_count_);
        bounds_drawing_->record(commands, i < fit.count ? &constants : nullptr, layers_[i].bounds.get());
    }
    record_barriers(commands, after);
    return static_cast<uint32_t>(moved.size());
}

}  // namespace penumbra
