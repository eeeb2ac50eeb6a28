// SPDX-License-Identifier: MIT
// The engine's frames: a G-buffer pass, penumbra's node, lighting. Two are in flight, and nothing waits but
// for the fence of the frame before the last.
#pragma once

#include <cstring>
#include <span>

#include "shadow_node.h"

namespace engine {

// What the engine's other passes do.
struct Rendered {
    std::function<std::vector<char>(uint32_t frame, const std::string& slot)> slot;  // as a slot holds it
    std::function<pen::FrameDescription(uint32_t frame)> frame;
    std::function<void(uint32_t frame, std::span<const char> visibility)> light;
};

// The exit code.
inline int run(const std::string& pipeline, pen::Extent extent, uint32_t frames, const Rendered& rendered) {
    open_device();
    constexpr uint32_t in_flight = 2;
    auto shadows = std::make_unique<ShadowNode>(pipeline, extent, in_flight);
    FrameGraph graph;
    for (const pen::HostSlot& slot : shadows->plan->slots)
        if (slot.kind == pen::PortKind::image)
            graph.images[slot.name] =
                make_image(pen::info(slot.format).vk, {slot.extent.width, slot.extent.height, 1},
                           VK_IMAGE_USAGE_SAMPLED_BIT |
                               (slot.output ? VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT
                                            : VK_IMAGE_USAGE_TRANSFER_DST_BIT),
                           slot.layered, slot.layers);

    struct InFlight {
        VkCommandPool pool;
        VkCommandBuffer cmd;
        VkFence fence;
        std::map<std::string, Buffer> buffers;  // of the frame, until its fence
        std::function<void()> done;
    } ring[in_flight];
    for (InFlight& slot : ring) {
        const VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr, 0, family};
        must(vkCreateCommandPool(device, &pool, nullptr, &slot.pool), "vkCreateCommandPool");
        const VkCommandBufferAllocateInfo allocate_info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                        nullptr, slot.pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                        1};
        must(vkAllocateCommandBuffers(device, &allocate_info, &slot.cmd), "vkAllocateCommandBuffers");
        const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr,
                                      VK_FENCE_CREATE_SIGNALED_BIT};
        must(vkCreateFence(device, &fence, nullptr, &slot.fence), "vkCreateFence");
    }
    const auto retire = [&](InFlight& slot) {  // the frame that was here has completed
        must(vkWaitForFences(device, 1, &slot.fence, VK_TRUE, UINT64_MAX), "vkWaitForFences");
        if (slot.done) slot.done();
        slot.done = {};
        for (const auto& [name, buffer] : slot.buffers) destroy(buffer);
        slot.buffers.clear();
    };

    for (uint32_t f = 0; f < frames; ++f) {
        InFlight& slot = ring[f % in_flight];
        retire(slot);
        must(vkResetFences(device, 1, &slot.fence), "vkResetFences");
        must(vkResetCommandPool(device, slot.pool, 0), "vkResetCommandPool");
        const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        must(vkBeginCommandBuffer(slot.cmd, &begin), "vkBeginCommandBuffer");

        // The G-buffer pass, and what it draws; uniform and texel buffers of the frame.
        std::map<std::string, Access> drawn;
        for (const pen::HostSlot& port : shadows->plan->slots) {
            if (port.output) continue;
            const std::vector<char> bytes = rendered.slot(f, port.name);
            const bool texels = port.kind == pen::PortKind::texels;
            Buffer& buffer = slot.buffers[port.name] =
                make_buffer(bytes.size(), texels ? pen::info(port.format).vk : VK_FORMAT_UNDEFINED);
            std::memcpy(buffer.mapped(), bytes.data(), bytes.size());
            if (port.kind == pen::PortKind::image) drawn[port.name] = copy_target;
        }
        graph.add(drawn, [&](VkCommandBuffer cmd) {
            for (const auto& [name, use] : drawn) {
                const Image& image = graph.images.at(name);
                const VkBufferImageCopy copy{0, 0, 0, {image.aspect, 0, 0, image.layers}, {}, image.extent};
                vkCmdCopyBufferToImage(cmd, slot.buffers.at(name).handle, image.handle, use.layout, 1, &copy);
            }
        });

        // Shadows.
        const pen::FrameDescription frame = rendered.frame(f);
        graph.add(shadows->uses(),
                  [&](VkCommandBuffer cmd) { shadows->record(cmd, frame, graph, slot.buffers); });

        // Lighting, which here is a copy that the processor looks at.
        const pen::HostSlot& output = shadows->plan->slots[*shadows->plan->slot("visibility")];
        const size_t size = size_t{extent.width} * extent.height * pen::info(output.format).bytes;
        const Buffer& result = slot.buffers["result"] = make_buffer(size, VK_FORMAT_UNDEFINED);
        graph.add({{"visibility", copy_source}}, [&](VkCommandBuffer cmd) {
            const Image& image = graph.images.at("visibility");
            const VkBufferImageCopy copy{0, 0, 0, {image.aspect, 0, 0, 1}, {}, image.extent};
            vkCmdCopyImageToBuffer(cmd, image.handle, copy_source.layout, result.handle, 1, &copy);
            VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
            barrier.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
            barrier.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
            barrier.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
            barrier.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
            VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
            info.memoryBarrierCount = 1;
            info.pMemoryBarriers = &barrier;
            vkCmdPipelineBarrier2(cmd, &info);
        });
        slot.done = [&, f, size] { rendered.light(f, {result.mapped(), size}); };

        graph.execute(slot.cmd);
        must(vkEndCommandBuffer(slot.cmd), "vkEndCommandBuffer");
        VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
        submit.commandBufferCount = 1;
        submit.pCommandBuffers = &slot.cmd;
        must(vkQueueSubmit(queue, 1, &submit, slot.fence), "vkQueueSubmit");
    }
    for (InFlight& slot : ring) {
        retire(slot);
        vkDestroyFence(device, slot.fence, nullptr);
        vkDestroyCommandPool(device, slot.pool, nullptr);
    }
    shadows.reset();
    for (const auto& [name, image] : graph.images) destroy(image);
    free_blocks();
    return close_device();
}

}  // namespace engine
