// SPDX-License-Identifier: MIT
// A plan to commands: per pass its dependency, clears, descriptors, push constants and dispatch, between two
// timestamps and inside a debug label.
#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "penumbra/view.h"

namespace penumbra {
namespace {

constexpr VkImageSubresourceRange whole_image{VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0,
                                              VK_REMAINING_ARRAY_LAYERS};

VkImageMemoryBarrier2 activate(VkImage image, VkPipelineStageFlags2 src, VkPipelineStageFlags2 dst,
                               VkAccessFlags2 access) {
    VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    barrier.srcStageMask = src;
    barrier.dstStageMask = dst;
    barrier.dstAccessMask = access;
    barrier.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange = whole_image;
    return barrier;
}

void memory_dependency(VkCommandBuffer cmd, VkPipelineStageFlags2 src_stages, VkAccessFlags2 src_access,
                       VkPipelineStageFlags2 dst_stages, VkAccessFlags2 dst_access,
                       std::span<const VkImageMemoryBarrier2> images = {}) {
    VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
    barrier.srcStageMask = src_stages;
    barrier.srcAccessMask = src_access;
    barrier.dstStageMask = dst_stages;
    barrier.dstAccessMask = dst_access;
    VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    info.memoryBarrierCount = src_stages ? 1 : 0;
    info.pMemoryBarriers = &barrier;
    info.imageMemoryBarrierCount = static_cast<uint32_t>(images.size());
    info.pImageMemoryBarriers = images.data();
    vkCmdPipelineBarrier2(cmd, &info);
}

// Everything before, before everything after: reset frames and poisoning, where cost does not matter.
void full_dependency(VkCommandBuffer cmd, std::span<const VkImageMemoryBarrier2> images = {}) {
    constexpr VkAccessFlags2 all = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    memory_dependency(cmd, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, all, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                      all, images);
}

VkClearColorValue poison_colour(FormatClass kind, uint32_t pattern) {
    VkClearColorValue colour{};
    for (int c = 0; c < 4; ++c) switch (kind) {
            case FormatClass::uint:
                colour.uint32[c] = pattern ? 0x5A5A5A5Au : 0xDEADBEEFu;
                break;
            case FormatClass::unorm:
                colour.float32[c] = pattern ? 0.1234f : 0.7312f;
                break;
            default:
                colour.float32[c] = pattern ? -3e4f : std::numeric_limits<float>::quiet_NaN();
                break;
        }
    return colour;
}

}  // namespace

void View::record(VkCommandBuffer cmd, const FrameDescription& frame, std::span<const SlotBinding> slots) {
    begin(cmd, frame, slots);
    for (size_t p = 0; p < plan().passes.size(); ++p) record_pass(cmd, p);
    end(cmd);
}

void View::begin(VkCommandBuffer cmd, const FrameDescription& frame, std::span<const SlotBinding> slots) {
    if (frame.size[0] != plan().extent.width || frame.size[1] != plan().extent.height)
        throw VulkanError(VK_ERROR_INITIALIZATION_FAILED,
                          fmt::format("the frame is {}x{}, the plan was compiled for {}x{}", frame.size[0],
                                      frame.size[1], plan().extent.width, plan().extent.height));
    check_slot_bindings(slots);
    parity_ = static_cast<uint32_t>(recorded_ & 1);
    slot_ = static_cast<uint32_t>(recorded_ % slots_.size());
    const Slot& slot = slots_[slot_];
    write_slot_bindings(slot, slots);

    frame_block_ = make_frame_block(frame);
    if (recorded_ == 0) frame_block_.flags |= frame_reset;
    std::memcpy(slot.frame_block.data(), &frame_block_, sizeof frame_block_);
    program_->record_uploads(cmd);
    if (slot.timestamps)
        vkCmdResetQueryPool(cmd, slot.timestamps.get(), 0, 2 * static_cast<uint32_t>(plan().passes.size()));
    if (!plan().counters.empty()) {
        vkCmdFillBuffer(cmd, slot.counters.get(), 0, VK_WHOLE_SIZE, 0);
        memory_dependency(cmd, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
    }
    if (frame_block_.flags & frame_reset) record_reset(cmd);
}

// No history exists: the previous parity's images and what is kept get a layout, those with `first: clear`
// (and, in tests, a poison) a value.
void View::record_reset(VkCommandBuffer cmd) {
    const uint32_t previous = 1 - parity_;
    std::vector<VkImageMemoryBarrier2> images;
    for (const ResetAction& action : plan().reset)
        if (const ResourceInstance& r = memory_.at(action.resource, previous); r.image)
            images.push_back(activate(r.image.get(), VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                      VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                      VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT));
    full_dependency(cmd, images);
    for (const ResetAction& action : plan().reset)
        if (action.clear || options_.poison)
            record_clear(cmd, action.resource, previous, action.clear ? std::nullopt : options_.poison);
    full_dependency(cmd);
}

void View::record_dependency(VkCommandBuffer cmd, const Dependency& dependency) const {
    if (dependency.empty()) return;
    std::vector<VkImageMemoryBarrier2> images;
    for (const Activation& a : dependency.activations)
        images.push_back(
            activate(memory_.at(a.resource, parity_).image.get(), a.src_stages, a.dst_stages, a.dst_access));
    memory_dependency(cmd, dependency.src_stages, dependency.src_access, dependency.dst_stages,
                      dependency.dst_access, images);
}

void View::record_clear(VkCommandBuffer cmd, uint32_t resource, uint32_t parity,
                        std::optional<uint32_t> poison) const {
    const ResourceInstance& r = memory_.at(resource, parity);
    const FormatClass kind = info(plan().resources[resource].format).kind;
    if (r.image) {
        const VkClearColorValue colour = poison ? poison_colour(kind, *poison) : VkClearColorValue{};
        vkCmdClearColorImage(cmd, r.image.get(), VK_IMAGE_LAYOUT_GENERAL, &colour, 1, &whole_image);
    } else {
        const uint32_t word = poison ? poison_colour(FormatClass::uint, *poison).uint32[0] : 0;
        vkCmdFillBuffer(cmd, r.buffer.get(), 0, VK_WHOLE_SIZE, word);
    }
}

void View::record_poison(VkCommandBuffer cmd, size_t pass) const {
    full_dependency(cmd);
    for (uint32_t i = 0; i < plan().resources.size(); ++i)
        if (plan().resources[i].first_pass == pass && !plan().resources[i].kept)
            record_clear(cmd, i, parity_, options_.poison);
    full_dependency(cmd);
}

void View::record_pass(VkCommandBuffer cmd, size_t index) {
    const PlanPass& pass = plan().passes[index];
    const Slot& slot = slots_[slot_];
    if (begin_label_) {
        VkDebugUtilsLabelEXT label{VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT};
        label.pLabelName = pass.node.c_str();
        begin_label_(cmd, &label);
    }
    record_dependency(cmd, pass.before[parity_]);
    if (options_.poison) record_poison(cmd, index);
    const auto first_query = static_cast<uint32_t>(2 * index);
    if (slot.timestamps)
        vkCmdWriteTimestamp2(cmd, VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT, slot.timestamps.get(), first_query);
    for (const uint32_t resource : pass.clears) record_clear(cmd, resource, parity_, std::nullopt);
    record_dependency(cmd, pass.after_clears[parity_]);
    switch (pass.kind) {
        case PassKind::capture:
            record_capture(cmd, index);
            break;
        case PassKind::host:
            record_host_pass(cmd, index);
            break;
        case PassKind::compute:
            record_dispatches(cmd, index);
    }
    if (slot.timestamps)
        vkCmdWriteTimestamp2(cmd, VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT, slot.timestamps.get(),
                             first_query + 1);
    if (end_label_) end_label_(cmd);
}

// One dispatch, or one per level of a mip chain: each reads what the one before has written.
void View::record_dispatches(VkCommandBuffer cmd, size_t index) const {
    const PlanPass& pass = plan().passes[index];
    const PassProgram& program = program_->pass(index);
    const std::vector<VkDescriptorSet>& levels = internal_sets_[index][parity_];
    vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, program.pipeline.get());
    if (!push_[index].empty())
        vkCmdPushConstants(cmd, program.layout.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                           static_cast<uint32_t>(push_[index].size()), push_[index].data());
    for (uint32_t level = 0; level < levels.size(); ++level) {
        if (level > 0)
            memory_dependency(cmd, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                              VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                              VK_ACCESS_2_SHADER_STORAGE_READ_BIT);
        const std::array sets{levels[level], slots_[slot_].sets[index]};
        vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, program.layout.get(), 0, 2, sets.data(),
                                0, nullptr);
        if (pass.mip_level)
            vkCmdPushConstants(cmd, program.layout.get(), VK_SHADER_STAGE_COMPUTE_BIT, *pass.mip_level,
                               sizeof level, &level);
        const std::array<uint32_t, 3>& groups = pass.mip_level ? pass.level_groups[level] : pass.groups;
        if (pass.indirect)
            vkCmdDispatchIndirect(cmd, memory_.at(*pass.indirect, parity_).buffer.get(),
                                  pass.indirect_offset);
        else
            vkCmdDispatch(cmd, groups[0], groups[1], groups[2]);
    }
}

void View::record_capture(VkCommandBuffer cmd, size_t index) const {
    const PlanBinding& binding = plan().passes[index].bindings.front();
    const ResourceInstance& r = instance(binding);
    size_t nth = 0;
    while (capture_passes_[nth] != index) ++nth;
    const MappedBuffer& target = slots_[slot_].captures[nth];
    if (r.image) {
        const Extent extent = plan().resources[binding.index].extent;
        VkBufferImageCopy copy{};
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, plan().resources[binding.index].layers};
        copy.imageExtent = {extent.width, extent.height, 1};
        vkCmdCopyImageToBuffer(cmd, r.image.get(), VK_IMAGE_LAYOUT_GENERAL, target.get(), 1, &copy);
    } else {
        const VkBufferCopy copy{0, 0, target.size()};
        vkCmdCopyBuffer(cmd, r.buffer.get(), target.get(), 1, &copy);
    }
}

void View::record_host_pass(VkCommandBuffer cmd, size_t index) const {
    const PlanPass& pass = plan().passes[index];
    HostPassContext context;
    context.cmd = cmd;
    context.pass = &pass;
    context.frame = &frame_block_;
    context.resource = [&](std::string_view port) -> const ResourceInstance* {
        const PlanBinding* binding = pass.binding(port);
        return binding && binding->source == BindingSource::resource ? &instance(*binding) : nullptr;
    };
    pass.callback(context);
}

void View::end(VkCommandBuffer cmd) {
    record_dependency(cmd, plan().end[parity_]);
    // Counters and captures are read by the host once the frame has completed.
    if (!plan().counters.empty() || !capture_passes_.empty())
        memory_dependency(cmd, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_COPY_BIT,
                          VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT,
                          VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
    ++recorded_;
}

}  // namespace penumbra
