// SPDX-License-Identifier: MIT
// A plan to commands: per pass its dependency, clears, descriptors, push constants and dispatch, between two
// timestamps and inside a debug label.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "graph/frame_check.h"
#include "graph/view_state.h"

namespace penumbra {
namespace {

constexpr VkImageSubresourceRange whole_image{VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0,
                                              VK_REMAINING_ARRAY_LAYERS};

VkImageMemoryBarrier2 activate(VkImage image, VkPipelineStageFlags2 src, VkPipelineStageFlags2 dst,
                               VkAccessFlags2 access, VkAccessFlags2 src_access = 0) {
    VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    barrier.srcStageMask = src;
    barrier.srcAccessMask = src_access;
    barrier.dstStageMask = dst;
    barrier.dstAccessMask = access;
    barrier.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange = whole_image;
    return barrier;
}

VkClearColorValue poison_colour(FormatClass kind, uint32_t pattern) {
    VkClearColorValue colour{};
    for (int c = 0; c < 4; ++c) switch (kind) {
            case FormatClass::uint:
                colour.uint32[c] = pattern ? 0x5A5A5A5Au : 0xDEADBEEFu;
                break;
            case FormatClass::unorm:
            case FormatClass::snorm:
                colour.float32[c] = pattern ? 0.1234f : 0.7312f;
                break;
            default:
                colour.float32[c] = pattern ? -3e4f : std::numeric_limits<float>::quiet_NaN();
                break;
        }
    return colour;
}

void check_commands(VkCommandBuffer cmd, const Plan& plan) {
    if (cmd == VK_NULL_HANDLE) fail(ErrorCode::usage, plan.pipeline, "the command buffer is null");
}

}  // namespace

void ViewState::memory_dependency(VkCommandBuffer cmd, const Dependency& d,
                                  std::span<const VkImageMemoryBarrier2> images) const {
    VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
    barrier.srcStageMask = d.src_stages;
    barrier.srcAccessMask = d.src_access;
    barrier.dstStageMask = d.dst_stages;
    barrier.dstAccessMask = d.dst_access;
    VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    info.memoryBarrierCount = d.src_stages ? 1 : 0;
    info.pMemoryBarriers = &barrier;
    info.imageMemoryBarrierCount = static_cast<uint32_t>(images.size());
    info.pImageMemoryBarriers = images.data();
    vk().vkCmdPipelineBarrier2(cmd, &info);
}

// Everything before, before everything after: reset frames, members that rest or wake, memos that begin anew,
// poisoning, and memory that another view has used.
void ViewState::full_dependency(VkCommandBuffer cmd, std::span<const VkImageMemoryBarrier2> images) const {
    constexpr VkAccessFlags2 all = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    static const Dependency everything{
        VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, all, all, {}};
    memory_dependency(cmd, everything, images);
}

void ViewState::begin(VkCommandBuffer cmd, const FrameDescription& frame,
                      std::span<const SlotBinding> slots) {
    const Extent size{frame.size[0], frame.size[1]};
    if (size.width == 0 || size.height == 0 || size.width > plan().extent.width ||
        size.height > plan().extent.height)
        fail(ErrorCode::usage, plan().pipeline,
             fmt::format("the frame is {}x{}, the plan was compiled for up to {}x{}", size.width, size.height,
                         plan().extent.width, plan().extent.height));
    check_commands(cmd, plan());
    const bool has_past = recorded_ > 0 || (options_.heir_of && options_.heir_of->state().recorded_ > 0);
    check_frame(frame, plan(), has_past);
    if (next_pass_ != not_begun && !(frame.flags & frame_reset))
        fail(ErrorCode::usage, plan().pipeline,
             "the frame before was begun and not ended: end(), or frame_reset");
    check_slot_bindings(slots);
    parity_ = static_cast<uint32_t>(recorded_ & 1);
    slot_ = static_cast<uint32_t>(recorded_ % slots_.size());
    const Slot& slot = slots_[slot_];
    if (recorded_ >= slots_.size()) {  // by the host's promise this frame has completed, if it ever ran
        if (has_run(slot)) {
            completed_.frame = recorded_ - slots_.size();
            read_statistics(slot, completed_.passes, ticks_);
            has_completed_ = true;
        }
    }
    std::ranges::copy(slots, bound_.begin());
    for (size_t i = 0; i < plan().resources.size(); ++i)
        if (const auto lent = plan().resources[i].slot)
            lent_[i] = {.image = bound_[*lent].handover->image, .view = bound_[*lent].image};
    write_slot_bindings(slot);

    frame_block_ = make_frame_block(frame, program_.device()->properties().limits.subPixelPrecisionBits);
    resting_ = asked_to_rest_;
    decide_reset(frame.flags);
    const bool reset = reset_.reason != Reset::Reason::none;
    const bool alike =
        (frame.flags & frame_unchanged) && !reset && !set_ && recorded_ > 0 && size == last_.size;
    unchanged_ = alike ? unchanged_ + 1 : 0;
    set_ = false;
    if (reset) frame_block_.flags |= frame_reset;
    const Extent before = reset ? size : recorded_ > 0 ? last_.size : options_.heir_of->state().last_.size;
    frame_block_.prev_size = {before.width, before.height};
    size_ = size;
    std::memcpy(slot.frame_block.data(), &frame_block_, sizeof frame_block_);
    expect_to_run(slot);
    // The frame before a reset may never have run, and with it the first uploads.
    if ((reset || recorded_ == 0) && !options_.tables_uploaded) program_.record_uploads(cmd);
    if (slot.timestamps)
        vk().vkCmdResetQueryPool(cmd, slot.timestamps.get(), 0,
                                 2 * static_cast<uint32_t>(plan().passes.size()));
    vk().vkCmdFillBuffer(cmd, slot.counters.get(), 0, VK_WHOLE_SIZE, 0);  // with what has_run() reads
    if (!plan().counters.empty())
        memory_dependency(cmd, {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                                VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                                {}});
    record_handovers(cmd, false);
    if (memory_.shares()) full_dependency(cmd);
    if (reset || recorded_ == 0)
        record_reset(cmd);
    else
        record_waking(cmd);
    for (KeptMemo& memo : kept_memos_) memo.stale = false;
    next_pass_ = 0;
}

// What the host hands over, before the frame's first pass, and what it gets back, behind the last.
void ViewState::record_handovers(VkCommandBuffer cmd, bool back) {
    images_.clear();
    buffers_.clear();
    const uint32_t own = device_.handles().queue_family;
    for (size_t i = 0; i < bound_.size(); ++i) {
        const SlotBinding& b = bound_[i];
        if (!b.handover) continue;
        const HostSlot& slot = plan().slots[i];
        const Handover& h = *b.handover;
        const uint32_t family = back ? h.family_after : h.family_before;
        const bool foreign = is_foreign(family);
        const bool image = slot.kind == PortKind::image;
        const VkImageLayout during = slot.output ? VK_IMAGE_LAYOUT_GENERAL : b.layout;
        const VkImageLayout outside = back ? h.layout_after : h.layout_before;
        if (slot.output && !back) continue;  // its activation waits for the host (record_dependency)
        const VkPipelineStageFlags2 stages = back ? h.stages_after : h.stages_before;
        const VkAccessFlags2 access = back ? h.access_after : h.access_before;
        if (!stages && !foreign && (!image || outside == during)) continue;
        // A transfer's other half is on the other queue, and so are the scopes there. Without stages of the
        // host's, a change of layout begins and ends at the frame's own scope, so that the host's barriers
        // (or a semaphore's wait) chain with it.
        const bool chains = !stages && !foreign;
        const VkPipelineStageFlags2 theirs = foreign && back ? VkPipelineStageFlags2{VK_PIPELINE_STAGE_2_NONE}
                                             : foreign || chains ? slot.use.stages
                                                                 : stages;
        const VkAccessFlags2 their_access = foreign  ? VkAccessFlags2{VK_ACCESS_2_NONE}
                                            : chains ? slot.use.access
                                                     : access;
        const VkAccessFlags2 ours =
            back ? (slot.output ? slot.use.access : VkAccessFlags2{VK_ACCESS_2_NONE}) : slot.use.access;
        const auto fill = [&](auto& barrier) {
            barrier.srcStageMask = back ? slot.use.stages : theirs;
            barrier.srcAccessMask = back ? ours : their_access;
            barrier.dstStageMask = back ? theirs : slot.use.stages;
            barrier.dstAccessMask = back ? their_access : ours;
            barrier.srcQueueFamilyIndex = !foreign ? VK_QUEUE_FAMILY_IGNORED : back ? own : family;
            barrier.dstQueueFamilyIndex = !foreign ? VK_QUEUE_FAMILY_IGNORED : back ? family : own;
        };
        const auto joins = [](auto& list, const auto& barrier, auto&& is_same) {  // in two slots, alike
            const auto same = std::ranges::find_if(list, is_same);                // (check_slot_bindings)
            if (same == list.end()) return false;
            same->srcStageMask |= barrier.srcStageMask;
            same->srcAccessMask |= barrier.srcAccessMask;
            same->dstStageMask |= barrier.dstStageMask;
            same->dstAccessMask |= barrier.dstAccessMask;
            return true;
        };
        if (image) {
            VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
            fill(barrier);
            if (joins(images_, barrier, [&](const auto& other) { return other.image == h.image; })) continue;
            barrier.oldLayout = back ? during : outside;
            barrier.newLayout = back ? outside : during;
            barrier.image = h.image;
            barrier.subresourceRange = whole_image;
            barrier.subresourceRange.aspectMask = h.aspects ? h.aspects : aspects_of(slot.format);
            images_.push_back(barrier);
        } else {
            VkBufferMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2};
            fill(barrier);
            if (joins(buffers_, barrier, [&](const auto& other) {
                    return other.buffer == b.buffer && other.offset == b.offset && other.size == b.range;
                }))
                continue;
            barrier.buffer = b.buffer;
            barrier.offset = b.offset;
            barrier.size = b.range;
            buffers_.push_back(barrier);
        }
    }
    if (images_.empty() && buffers_.empty()) return;
    VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    dependency.bufferMemoryBarrierCount = static_cast<uint32_t>(buffers_.size());
    dependency.pBufferMemoryBarriers = buffers_.data();
    dependency.imageMemoryBarrierCount = static_cast<uint32_t>(images_.size());
    dependency.pImageMemoryBarriers = images_.data();
    vk().vkCmdPipelineBarrier2(cmd, &dependency);
}

// The previous parity's images and what is kept get a layout. They get what the view before has left; else
// no history exists, and those with `first: clear` (and, in tests, a poison) get a value.
void ViewState::record_reset(VkCommandBuffer cmd) {
    const uint32_t previous = 1 - parity_;
    images_.clear();
    for (const ResetAction& action : plan().reset)
        if (const VkImage image = memory_.at(action.resource, previous).image)
            images_.push_back(activate(image, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                       VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                       VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT));
    full_dependency(cmd, images_);
    for (size_t i = 0; i < plan().reset.size(); ++i) {
        const ResetAction& action = plan().reset[i];
        if (i < inherited_.size() && inherited_[i]) continue;
        const bool zero = action.clear || is_zero_at_rest(action.resource);
        if (zero || options_.poison)
            record_clear(cmd, action.resource, previous, zero ? std::nullopt : options_.poison);
    }
    record_inheritance(cmd);
    full_dependency(cmd);
}

void ViewState::record_dependency(VkCommandBuffer cmd, const Dependency& dependency) {
    if (dependency.empty()) return;
    images_.clear();
    for (const Activation& a : dependency.activations) {
        VkPipelineStageFlags2 before = a.src_stages;
        VkAccessFlags2 access = a.src_access;
        // What was cleared in a resting pass's place may have had no reader, of whom the plan knows.
        if (slept_) {
            before |= VK_PIPELINE_STAGE_2_CLEAR_BIT;
            access |= VK_ACCESS_2_TRANSFER_WRITE_BIT;
        }
        if (const auto lent = plan().resources[a.resource].slot) {
            const Handover& h = *bound_[*lent].handover;
            if (!is_foreign(h.family_before)) {  // another queue's stages are not this one's
                before |= h.stages_before;
                access |= h.access_before;
            }
        }
        images_.push_back(
            activate(instance(a.resource, false).image, before, a.dst_stages, a.dst_access, access));
    }
    memory_dependency(cmd, dependency, images_);
}

void ViewState::record_clear(VkCommandBuffer cmd, uint32_t resource, uint32_t parity,
                             std::optional<uint32_t> poison) const {
    const ResourceHandles& r =
        plan().resources[resource].slot ? lent_[resource] : memory_.at(resource, parity);
    const FormatClass kind = info(plan().resources[resource].format).kind;
    if (r.image) {
        const VkClearColorValue colour = poison ? poison_colour(kind, *poison) : VkClearColorValue{};
        vk().vkCmdClearColorImage(cmd, r.image, VK_IMAGE_LAYOUT_GENERAL, &colour, 1, &whole_image);
    } else {
        const uint32_t word = poison ? poison_colour(FormatClass::uint, *poison).uint32[0] : 0;
        vk().vkCmdFillBuffer(cmd, r.buffer, 0, VK_WHOLE_SIZE, word);
    }
}

void ViewState::record_poison(VkCommandBuffer cmd, size_t pass) const {
    full_dependency(cmd);
    for (uint32_t i = 0; i < plan().resources.size(); ++i)
        if (plan().resources[i].first_pass == pass && !plan().resources[i].kept)
            record_clear(cmd, i, parity_, options_.poison);
    full_dependency(cmd);
}

void ViewState::record_pass(VkCommandBuffer cmd, size_t index) {
    if (index != next_pass_ || index >= plan().passes.size())
        fail(ErrorCode::usage, plan().pipeline, "passes are recorded in order, between begin() and end()");
    check_commands(cmd, plan());
    ++next_pass_;
    const PlanPass& pass = plan().passes[index];
    const Slot& slot = slots_[slot_];
    if (vk().vkCmdBeginDebugUtilsLabelEXT) {
        VkDebugUtilsLabelEXT label{VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT};
        label.pLabelName = pass.node.c_str();
        vk().vkCmdBeginDebugUtilsLabelEXT(cmd, &label);
    }
    record_dependency(cmd, pass.before[parity_]);
    if (options_.poison) record_poison(cmd, index);
    const auto first_query = static_cast<uint32_t>(2 * index);
    if (slot.timestamps)
        vk().vkCmdWriteTimestamp2(cmd, VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT, slot.timestamps.get(),
                                  first_query);
    // Dependencies hold whether it rests or not: what shares its memory waits through them.
    if (rests(pass)) {
        record_dependency(cmd, pass.after_clears[parity_]);
        record_rest(cmd, pass);
    } else {
        for (const uint32_t resource : pass.clears) record_clear(cmd, resource, parity_, std::nullopt);
        record_dependency(cmd, pass.after_clears[parity_]);
        record_work(cmd, index);
    }
    if (slot.timestamps)
        vk().vkCmdWriteTimestamp2(cmd, VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT, slot.timestamps.get(),
                                  first_query + 1);
    if (vk().vkCmdEndDebugUtilsLabelEXT) vk().vkCmdEndDebugUtilsLabelEXT(cmd);
}

void ViewState::record_work(VkCommandBuffer cmd, size_t index) const {
    switch (plan().passes[index].kind) {
        case PassKind::capture:
            record_capture(cmd, index);
            break;
        case PassKind::host:
            record_host_pass(cmd, index);
            break;
        case PassKind::compute:
            record_dispatches(cmd, index);
    }
}

// One dispatch, or one per level of a mip chain: each reads what the one before has written.
void ViewState::record_dispatches(VkCommandBuffer cmd, size_t index) const {
    const PlanPass& pass = plan().passes[index];
    const PassProgram& program = program_.pass(index);
    const std::vector<VkDescriptorSet>& levels = internal_sets_[index][parity_];
    vk().vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, program.pipeline.get());
    if (!push_[index].empty())
        vk().vkCmdPushConstants(cmd, program.layout.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                                static_cast<uint32_t>(push_[index].size()), push_[index].data());
    for (uint32_t level = 0; level < levels.size(); ++level) {
        if (level > 0)
            memory_dependency(cmd, {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                    VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                                    VK_ACCESS_2_SHADER_STORAGE_READ_BIT,
                                    {}});
        const std::array sets{levels[level], slots_[slot_].sets[index]};
        vk().vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, program.layout.get(), 0, 2,
                                     sets.data(), 0, nullptr);
        if (pass.mip_level)
            vk().vkCmdPushConstants(cmd, program.layout.get(), VK_SHADER_STAGE_COMPUTE_BIT, *pass.mip_level,
                                    sizeof level, &level);
        const std::array<uint32_t, 3> groups = pass.groups_at(size_, level);
        if (pass.indirect)
            vk().vkCmdDispatchIndirect(cmd, memory_.at(*pass.indirect, parity_).buffer, pass.indirect_offset);
        else
            vk().vkCmdDispatch(cmd, groups[0], groups[1], groups[2]);
    }
}

void ViewState::record_capture(VkCommandBuffer cmd, size_t index) const {
    const PlanBinding& binding = plan().passes[index].bindings.front();
    const ResourceHandles& r = instance(binding.index, binding.previous);
    size_t nth = 0;
    while (capture_passes_[nth] != index) ++nth;
    const MappedBuffer& target = slots_[slot_].captures[nth];
    if (r.image) {
        const PlanResource& resource = plan().resources[binding.index];
        // An image of the host's own may be no larger than the frame.
        const Extent extent =
            resource.slot && resource.follows ? resource.follows->at(size_) : resource.extent;
        VkBufferImageCopy copy{};
        copy.bufferRowLength = resource.extent.width;
        copy.bufferImageHeight = resource.extent.height;
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, resource.layers};
        copy.imageExtent = {extent.width, extent.height, 1};
        vk().vkCmdCopyImageToBuffer(cmd, r.image, VK_IMAGE_LAYOUT_GENERAL, target.get(), 1, &copy);
    } else {
        const VkBufferCopy copy{0, 0, target.size()};
        vk().vkCmdCopyBuffer(cmd, r.buffer, target.get(), 1, &copy);
    }
}

void ViewState::record_host_pass(VkCommandBuffer cmd, size_t index) const {
    const PlanPass& pass = plan().passes[index];
    pass.callback({cmd, &pass, &frame_block_, options_.user, this});
}

void ViewState::end(VkCommandBuffer cmd) {
    if (next_pass_ != plan().passes.size())
        fail(ErrorCode::usage, plan().pipeline, "end() comes behind begin() and every pass");
    check_commands(cmd, plan());
    next_pass_ = not_begun;
    record_dependency(cmd, plan().end[parity_]);
    record_handovers(cmd, true);
    // Counters and captures are read by the host once the frame has completed.
    memory_dependency(cmd, {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_COPY_BIT |
                                VK_PIPELINE_STAGE_2_CLEAR_BIT,
                            VK_PIPELINE_STAGE_2_HOST_BIT,
                            VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT,
                            VK_ACCESS_2_HOST_READ_BIT,
                            {}});
    ++recorded_;
    rested_ = resting_;
    last_.size = size_;
    last_.parity = parity_;
    last_.lent = lent_;  // as many every time: nothing is allocated
    for (size_t i = 0; i < lent_.size(); ++i)
        if (const auto slot = plan().resources[i].slot)
            last_.lent[i].layout = bound_[*slot].handover->layout_after;
}

}  // namespace penumbra
