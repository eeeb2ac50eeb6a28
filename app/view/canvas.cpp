// SPDX-License-Identifier: MIT
// The picture is blitted, since this Dear ImGui draws no textures but its own font's with Vulkan.
#include "app/view/canvas.h"

#include <backends/imgui_impl_vulkan.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace penumbra::viewer {
namespace {

void check_ui(VkResult result) {
    check(result, "Dear ImGui's Vulkan backend", "the user interface");
}

Owned<VkRenderPass> make_pass(const Device& device) {
    VkAttachmentDescription color{};
    color.format = Canvas::format;
    color.samples = VK_SAMPLE_COUNT_1_BIT;
    color.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;  // the picture is there already
    color.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    color.initialLayout = color.finalLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &reference;
    VkRenderPassCreateInfo create{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    create.attachmentCount = 1;
    create.pAttachments = &color;
    create.subpassCount = 1;
    create.pSubpasses = &subpass;
    VkRenderPass pass = VK_NULL_HANDLE;
    check(vkCreateRenderPass(device.get(), &create, nullptr, &pass), "vkCreateRenderPass", "user interface");
    return {device.get(), pass};
}

Owned<VkDescriptorPool> make_pool(const Device& device) {
    const VkDescriptorPoolSize font{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1};
    VkDescriptorPoolCreateInfo create{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    create.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;
    create.maxSets = create.poolSizeCount = 1;
    create.pPoolSizes = &font;
    VkDescriptorPool pool = VK_NULL_HANDLE;
    check(vkCreateDescriptorPool(device.get(), &create, nullptr, &pool), "vkCreateDescriptorPool",
          "user interface");
    return {device.get(), pool};
}

std::array<VkOffset3D, 2> corners(const Area& area) {
    const auto whole = [](float v) { return static_cast<int32_t>(std::lround(v)); };
    return {
        {{whole(area.x), whole(area.y), 0}, {whole(area.x + area.width), whole(area.y + area.height), 1}}};
}

}  // namespace

Area fitted(const Area& room, uint32_t width, uint32_t height) {
    const float scale =
        std::min(room.width / static_cast<float>(width), room.height / static_cast<float>(height));
    const float w = scale * static_cast<float>(width), h = scale * static_cast<float>(height);
    return {room.x + (room.width - w) / 2, room.y + (room.height - h) / 2, w, h};
}

Canvas::Canvas(Device& device, VkExtent2D extent)
    : device_(device), pass_(make_pass(device)), pool_(make_pool(device)) {
    resize(extent);
    ImGui_ImplVulkan_InitInfo info{};
    info.Instance = device.instance();
    info.PhysicalDevice = device.physical();
    info.Device = device.get();
    info.QueueFamily = device.queue_family();
    info.Queue = device.queue();
    info.DescriptorPool = pool_.get();
    info.MinImageCount = info.ImageCount = 2;  // copies of its vertices; frames are waited for here
    info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
    info.CheckVkResultFn = check_ui;
    ImGui_ImplVulkan_Init(&info, pass_.get());
    device.run([](VkCommandBuffer cmd) { ImGui_ImplVulkan_CreateFontsTexture(cmd); });
    ImGui_ImplVulkan_DestroyFontUploadObjects();
}

Canvas::~Canvas() {
    ImGui_ImplVulkan_Shutdown();
}

void Canvas::resize(VkExtent2D extent) {
    if (image_.get() && image_.extent.width == extent.width && image_.extent.height == extent.height) return;
    framebuffer_ = {};
    image_ = make_image(device_, format, extent, 1,
                        VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                            VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                        "the window's picture");
    const VkImageView view = image_.view.get();
    VkFramebufferCreateInfo create{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    create.renderPass = pass_.get();
    create.attachmentCount = 1;
    create.pAttachments = &view;
    create.width = extent.width;
    create.height = extent.height;
    create.layers = 1;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    check(vkCreateFramebuffer(device_.get(), &create, nullptr, &framebuffer), "vkCreateFramebuffer",
          "user interface");
    framebuffer_ = {device_.get(), framebuffer};
}

void Canvas::upload(const Picture& picture) {
    const VkExtent2D extent{picture.width, picture.height};
    if (!picture_.get() || picture_.extent.width != extent.width || picture_.extent.height != extent.height) {
        picture_ = make_image(
            device_, format, extent, 1,
            VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
            "the picture");
        staging_ =
            make_host_buffer(device_, picture.rgba.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, "the picture");
    }
    std::memcpy(staging_.mapped, picture.rgba.data(), picture.rgba.size());
}

void Canvas::draw(const Picture& picture, const Area& area, ImDrawData* ui) {
    upload(picture);
    device_.run([&](VkCommandBuffer cmd) {
        const auto change = [&](const GpuImage& image, VkImageLayout from, VkImageLayout to) {
            full_barrier(cmd, image.get(), image.format, from, to);
        };
        change(picture_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        VkBufferImageCopy copy{};
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.imageExtent = {picture.width, picture.height, 1};
        vkCmdCopyBufferToImage(cmd, staging_.get(), picture_.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                               &copy);
        change(picture_, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        change(image_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        const VkClearColorValue around{{0.07f, 0.075f, 0.08f, 1}};
        const VkImageSubresourceRange whole{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        vkCmdClearColorImage(cmd, image_.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &around, 1, &whole);
        change(image_, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        VkImageBlit blit{};
        blit.srcSubresource = blit.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        blit.srcOffsets[1] = {static_cast<int32_t>(picture.width), static_cast<int32_t>(picture.height), 1};
        const std::array<VkOffset3D, 2> to = corners(area);
        std::copy(to.begin(), to.end(), blit.dstOffsets);
        if (to[0].x < to[1].x && to[0].y < to[1].y)
            vkCmdBlitImage(cmd, picture_.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, image_.get(),
                           VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit, VK_FILTER_NEAREST);
        change(image_, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
        begin.renderPass = pass_.get();
        begin.framebuffer = framebuffer_.get();
        begin.renderArea.extent = image_.extent;
        vkCmdBeginRenderPass(cmd, &begin, VK_SUBPASS_CONTENTS_INLINE);
        ImGui_ImplVulkan_RenderDrawData(ui, cmd);
        vkCmdEndRenderPass(cmd);
        change(image_, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    });
}

std::vector<uint8_t> Canvas::rgba() {
    const std::vector<std::byte> bytes =
        read_image(device_, image_.get(), format, image_.extent, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    std::vector<uint8_t> out(bytes.size());
    std::memcpy(out.data(), bytes.data(), bytes.size());
    for (size_t i = 3; i < out.size(); i += 4) out[i] = 255;
    return out;
}

}  // namespace penumbra::viewer
