// SPDX-License-Identifier: MIT
// Per frame: one record per draw written in double precision, then all draws in one dynamic rendering.
#include "host/gbuffer/gbuffer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

namespace penumbra {

namespace {

glm::dvec3 position_of(const Camera& camera) {
    return glm::make_vec3(camera.position.data());
}

// Camera-relative metres in world axes -> clip.
glm::dmat4 clip_from_rel(const Camera& camera) {
    return glm::make_mat4(camera.clip_from_view.data()) *
           glm::dmat4(glm::transpose(glm::make_mat3(camera.world_from_view.data())));
}

// The part's frame -> camera-relative metres: the difference of the two positions is taken before anything is
// rounded.
glm::dmat4 rel_from_local(const glm::dmat4& world, const glm::dvec3& part_origin, const glm::dvec3& origin,
                          const Camera& camera) {
    glm::dmat4 result = glm::translate(world, part_origin);
    result[3] += glm::dvec4(origin - position_of(camera), 0);
    return result;
}

double largest_element(const glm::dmat3& m) {
    double largest = 0;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) largest = std::max(largest, std::abs(m[c][r]));
    return largest;
}

VkImageMemoryBarrier2 transition(const GpuImage& image, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image.get();
    barrier.subresourceRange = {
        is_depth(image.format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    return barrier;
}

constexpr VkPipelineStageFlags2 depth_stages =
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;

void barriers(VkCommandBuffer commands, std::span<const VkImageMemoryBarrier2> list) {
    VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    dependency.imageMemoryBarrierCount = static_cast<uint32_t>(list.size());
    dependency.pImageMemoryBarriers = list.data();
    vkCmdPipelineBarrier2(commands, &dependency);
}

// Old contents are dropped; readers of the previous frame (any stage) come first.
void begin_writing(VkCommandBuffer commands, std::span<const GpuImage* const> images) {
    std::vector<VkImageMemoryBarrier2> list;
    for (const GpuImage* image : images) {
        const bool depth = is_depth(image->format);
        VkImageMemoryBarrier2& barrier = list.emplace_back(
            transition(*image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL));
        barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
        barrier.dstStageMask = depth ? depth_stages : VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
        barrier.dstAccessMask = depth ? VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
                                            VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT
                                      : VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
    }
    barriers(commands, list);
}

void hand_over(VkCommandBuffer commands, std::span<const GpuImage* const> images) {
    std::vector<VkImageMemoryBarrier2> list;
    for (const GpuImage* image : images) {
        VkImageMemoryBarrier2& barrier =
            list.emplace_back(transition(*image, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, GBuffer::final_layout));
        barrier.srcStageMask = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
        barrier.srcAccessMask = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
        barrier.dstStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT |
                               VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_COPY_BIT;
        barrier.dstAccessMask = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_TRANSFER_READ_BIT;
    }
    barriers(commands, list);
}

VkRenderingAttachmentInfo cleared_attachment(const GpuImage& image) {
    VkRenderingAttachmentInfo info{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    info.imageView = image.view.get();
    info.imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
    info.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;  // all zeros: reverse-Z's far end, no normal, no motion, black
    info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    return info;
}

// The inverse of clip_from_view for a pixel's ndc, in world axes.
DrawConstants frame_constants(const FrameDescription& frame, VkExtent2D extent) {
    const auto clip = glm::make_mat4(frame.camera.clip_from_view.data());
    const auto axes = glm::make_mat3(frame.camera.world_from_view.data());
    const bool orthographic = frame.flags & frame_orthographic;
    const glm::dvec2 shift = orthographic ? -glm::dvec2(clip[3]) : glm::dvec2(clip[2]);
    const glm::dvec3 ray_x = axes[0] / clip[0][0], ray_y = axes[1] / clip[1][1];
    const glm::dvec3 ray_0 = shift.x * ray_x + shift.y * ray_y - (orthographic ? glm::dvec3(0) : axes[2]);
    return {glm::vec2(2 * frame.jitter[0], 2 * frame.jitter[1]),
            glm::vec2(2.0 / extent.width, 2.0 / extent.height),
            glm::vec4(ray_x, -clip[2][2]),
            glm::vec4(ray_y, clip[3][2]),
            glm::vec4(ray_0, orthographic),
            glm::vec4(-axes[2], 0),
            0};
}

}  // namespace

uint64_t gbuffer_bytes_per_pixel() {
    uint64_t bytes = texel_bytes(gbuffer_test_format);
    for (size_t i = 0; i < gbuffer_colors_without_materials; ++i)
        bytes += texel_bytes(gbuffer_color_formats[i]);
    return bytes;
}

GBuffer::GBuffer(Device& device, const Scene& scene, VkExtent2D extent, uint32_t frames_in_flight,
                 bool materials)
    : device_(device),
      scene_(scene),
      materials_(materials),
      geometry_(make_raster_geometry(scene.model())),
      textures_(device, scene.model().materials, scene.model().textures, materials) {
    const RasterGeometry& geometry = geometry_;
    vertices_ = upload_buffer(device, std::as_bytes(std::span(geometry.vertices)),
                              VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, "vertices");
    indices_ = upload_buffer(device, std::as_bytes(std::span(geometry.indices)),
                             VK_BUFFER_USAGE_INDEX_BUFFER_BIT, "indices");
    for (const Instance& instance : scene.instances()) {
        const auto mesh = static_cast<size_t>(instance.mesh);
        const std::vector<Part>& parts = scene.model().meshes[mesh].parts;
        for (size_t i = 0; i < parts.size(); ++i) {
            const int material = parts[i].material;
            const bool translucent = scene.translucent(parts[i]);
            uint32_t least_alpha = 0;
            if (translucent || scene.alpha_tested(parts[i])) {
                const Material& of = scene.model().materials[static_cast<size_t>(material)];
                // The rest is drawn by whoever draws what is behind through it.
                if (translucent && !scene.has_opaque_texels(parts[i])) continue;
                least_alpha = least_opaque_alpha(of);
            }
            DrawItem& item = items_.emplace_back();
            item = {instance, &parts[i], geometry.meshes[mesh][i], least_alpha, VK_NULL_HANDLE, {}, {}};
            if (!scene.deforms(instance, parts[i])) continue;
            for (auto* list : {&item.vertices, &item.prev_vertices})
                for (uint32_t slot = 0; slot < frames_in_flight; ++slot)
                    list->push_back(make_host_buffer(device, item.range.vertex_count * sizeof(RasterVertex),
                                                     VK_BUFFER_USAGE_VERTEX_BUFFER_BIT,
                                                     "vertices that deform"));
        }
    }
    create_images(extent);
    create_draw_records(frames_in_flight);
    create_pipelines();
}

void GBuffer::create_images(VkExtent2D extent) {
    constexpr VkImageUsageFlags read = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    constexpr VkImageUsageFlags color = read | VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    tested_ = make_image(device_, gbuffer_test_format, extent, 1, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
                         "depth that is tested");
    images_.depth = make_image(device_, gbuffer_color_formats[0], extent, 1, color, "depth");
    images_.normal = make_image(device_, gbuffer_color_formats[1], extent, 1, color, "normal");
    images_.motion = make_image(device_, gbuffer_color_formats[2], extent, 1, color, "motion");
    images_.albedo = make_image(device_, gbuffer_color_formats[3], extent, 1, color, "albedo");
    if (!materials_) return;
    images_.material = make_image(device_, gbuffer_color_formats[4], extent, 1, color, "material");
    images_.emissive = make_image(device_, gbuffer_color_formats[5], extent, 1, color, "emissive");
}

std::vector<const GpuImage*> GBuffer::color_images() const {
    std::vector<const GpuImage*> images{&images_.depth, &images_.normal, &images_.motion, &images_.albedo};
    if (materials_) images.insert(images.end(), {&images_.material, &images_.emissive});
    return images;
}

void GBuffer::create_draw_records(uint32_t frames_in_flight) {
    VkDescriptorSetLayoutBinding binding{};
    binding.descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC;
    binding.descriptorCount = 1;
    binding.stageFlags = draw_constant_stages;
    draws_ = make_descriptor_sets(device_, {&binding, 1}, frames_in_flight, "draw records");
    const VkDeviceSize bytes = std::max<size_t>(items_.size(), 1) * sizeof(DrawRecord);
    for (uint32_t slot = 0; slot < frames_in_flight; ++slot) {
        records_.push_back(
            make_host_buffer(device_, bytes, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, "draw records"));
        write_part(device_, draws_.sets[slot], 0, records_.back(), sizeof(DrawRecord));
    }
}

void GBuffer::create_pipelines() {
    const VkDescriptorSetLayout sets[] = {draws_.layout.get(), textures_.layout()};
    pipeline_layout_ =
        make_pipeline_layout(device_, sets, draw_constant_stages, sizeof(DrawConstants), "G-buffer");
    for (DrawItem& item : items_) {
        const DrawnAs as{item.least_alpha > 0, textures_.textured(item.part->material)};
        Owned<VkPipeline>& pipeline = pipelines_[as];
        if (!pipeline)
            pipeline =
                make_gbuffer_pipeline(device_, pipeline_layout_.get(), images_.depth.extent, as, materials_);
        item.pipeline = pipeline.get();
    }
}

void GBuffer::write_draw_records(const FrameDescription& frame, double moment, double previous,
                                 const glm::dvec3& origin, size_t slot) {
    const std::vector<glm::dmat4> world = scene_.transforms(moment), prev_world = scene_.transforms(previous);
    const glm::dmat4 clip = clip_from_rel(frame.camera), prev_clip = clip_from_rel(frame.previous);
    auto* records = static_cast<DrawRecord*>(records_[slot].mapped);
    for (size_t i = 0; i < items_.size(); ++i) {
        const DrawItem& item = items_[i];
        const auto node = static_cast<size_t>(item.instance.node);
        const glm::dmat4 rel = rel_from_local(world[node], item.part->origin, origin, frame.camera);
        const glm::dmat4 prev_rel =
            rel_from_local(prev_world[node], item.part->origin, origin, frame.previous);
        const glm::dmat3 linear(rel);
        const double largest = largest_element(cofactors(linear));
        const glm::dmat3 normals = cofactors(linear) / largest;
        const glm::dvec3 camera = -(glm::inverse(linear) * glm::dvec3(rel[3]));

        DrawRecord record{};
        record.clip_from_local = glm::mat4(clip * rel);
        record.prev_clip_from_local = glm::mat4(prev_clip * prev_rel);
        for (int c = 0; c < 3; ++c) record.world_from_local[c] = glm::vec4(glm::vec3(normals[c]), 0);
        record.camera_local = glm::vec4(glm::vec3(camera), glm::determinant(linear) / largest);
        record.camera_local_low = glm::vec4(camera - glm::dvec3(glm::vec3(camera)), 0);
        record.base_color = glm::vec4(1);
        const float single_sided = item.part->single_sided ? 1.0f : 0.0f;
        record.metallic_roughness = glm::vec4(0, 1, single_sided, 0);
        if (item.part->material >= 0) {
            const Material& material = scene_.model().materials[static_cast<size_t>(item.part->material)];
            record.base_color = glm::make_vec4(material.base_color.data());
            record.metallic_roughness = glm::vec4(material.metallic, material.roughness, single_sided, 0);
            record.emissive = glm::vec4(glm::make_vec3(material.emissive.data()), 0);
        }
        std::memcpy(records + i, &record, sizeof(record));
    }
}

// Motion vectors need where every vertex was, with the triangles of now.
void GBuffer::write_deformed(double moment, double previous, size_t slot) {
    if (std::ranges::all_of(items_, [](const DrawItem& item) { return item.vertices.empty(); })) return;
    const Scene::Pose now = scene_.pose(moment), before = scene_.pose(previous);
    for (DrawItem& item : items_) {
        if (item.vertices.empty()) continue;
        const auto write = [&](GpuBuffer& buffer, const Scene::Pose& pose) {
            const std::vector<RasterVertex> vertices =
                moved_vertices(geometry_, item.range, scene_.positions(item.instance, *item.part, pose));
            std::memcpy(buffer.mapped, vertices.data(), vertices.size() * sizeof(RasterVertex));
        };
        write(item.vertices[slot], now);
        write(item.prev_vertices[slot], before);
    }
}

void GBuffer::record(VkCommandBuffer commands, const FrameDescription& frame, double moment, double previous,
                     const glm::dvec3& origin) {
    const size_t slot = frame.index % records_.size();
    write_draw_records(frame, moment, previous, origin, slot);
    write_deformed(moment, previous, slot);

    const std::vector<const GpuImage*> images = color_images();
    std::vector<VkRenderingAttachmentInfo> colors;
    for (const GpuImage* image : images) colors.push_back(cleared_attachment(*image));
    std::vector<const GpuImage*> all = images;
    all.push_back(&tested_);
    begin_writing(commands, all);
    VkRenderingAttachmentInfo depth = cleared_attachment(tested_);
    depth.storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    VkRenderingInfo rendering{VK_STRUCTURE_TYPE_RENDERING_INFO};
    rendering.renderArea = {{0, 0}, images_.depth.extent};
    rendering.layerCount = 1;
    rendering.colorAttachmentCount = static_cast<uint32_t>(colors.size());
    rendering.pColorAttachments = colors.data();
    rendering.pDepthAttachment = &depth;
    vkCmdBeginRendering(commands, &rendering);
    draw(commands, frame, slot);
    vkCmdEndRendering(commands);
    hand_over(commands, images);
}

void GBuffer::draw(VkCommandBuffer commands, const FrameDescription& frame, size_t slot) const {
    const VkExtent2D extent = images_.depth.extent;
    VkBuffer bound_vertices = VK_NULL_HANDLE;
    vkCmdBindIndexBuffer(commands, indices_.get(), 0, VK_INDEX_TYPE_UINT32);
    VkDescriptorSet bound = VK_NULL_HANDLE;
    VkPipeline drawn_with = VK_NULL_HANDLE;
    DrawConstants constants = frame_constants(frame, extent);
    for (size_t i = 0; i < items_.size(); ++i) {
        const DrawItem& item = items_[i];
        const int material = item.part->material;
        const VkDescriptorSet texture = textures_.set(material);
        if (texture != bound) {
            vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_layout_.get(), 1, 1,
                                    &texture, 0, nullptr);
            bound = texture;
        }
        if (item.pipeline != drawn_with) {
            vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, item.pipeline);
            drawn_with = item.pipeline;
        }
        const bool deforms = !item.vertices.empty();
        const VkBuffer now = deforms ? item.vertices[slot].get() : vertices_.get(),
                       before = deforms ? item.prev_vertices[slot].get() : now;
        if (now != bound_vertices) {
            const VkBuffer both[] = {now, before};
            const VkDeviceSize zeros[] = {0, 0};
            vkCmdBindVertexBuffers(commands, 0, 2, both, zeros);
            bound_vertices = now;
        }
        const auto record = static_cast<uint32_t>(i * sizeof(DrawRecord));
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_layout_.get(), 0, 1,
                                &draws_.sets[slot], 1, &record);
        constants.least_alpha = item.least_alpha;
        vkCmdPushConstants(commands, pipeline_layout_.get(), draw_constant_stages, 0, sizeof(constants),
                           &constants);
        vkCmdDrawIndexed(commands, item.range.index_count, 1, item.range.first_index,
                         deforms ? 0 : item.range.vertex_offset, 0);
    }
}

}  // namespace penumbra
