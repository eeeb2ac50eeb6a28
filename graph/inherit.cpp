// SPDX-License-Identifier: MIT
// What a view's first frame gets of the view that it is the heir of: which of its histories mean the same
// there, and their copies. A frame that gets nothing is a reset.
#include <algorithm>

#include "graph/view_state.h"

namespace penumbra {
namespace {

// Whether two plans mean the same by a name whose value lasts. Where both follow the frame's size, their
// largest ones may differ.
bool alike(const PlanResource& a, const PlanResource& b) {
    const bool same_size = a.extent == b.extent && a.levels == b.levels && a.count == b.count;
    return a.names.back() == b.names.back() && a.kind == b.kind && a.format == b.format &&
           a.layered == b.layered && a.layers == b.layers && a.kept == b.kept && a.element == b.element &&
           a.follows == b.follows && (a.follows || same_size);
}

// A kept memo may be what another plan's parameters made of it, and nothing would ever make it anew.
bool is_own(const PlanResource& r) {
    return r.kept && r.memo;
}

// Compiled with CompileOptions::hand_on_history, or may be copied from and to for other reasons.
bool hands_on(const PlanResource& r) {
    const bool image = r.kind == PortKind::image;
    constexpr VkImageUsageFlags of_image = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    constexpr VkBufferUsageFlags of_buffer =
        VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    return image ? (r.image_usage & of_image) == of_image : (r.buffer_usage & of_buffer) == of_buffer;
}

}  // namespace

void ViewState::reset_for(Reset::Reason reason, const PlanResource& resource) {
    reset_.reason = reason;
    reset_.resource = resource.names.back();  // which has room for it
}

void ViewState::decide_reset(uint32_t flags) {
    reset_.reason = Reset::Reason::none;
    reset_.resource.clear();
    inherited_.clear();
    if (flags & frame_reset) reset_.reason = Reset::Reason::asked;
    if (recorded_ > 0) return decide_waking();
    const ViewState* before = options_.heir_of ? &options_.heir_of->state() : nullptr;
    if (!before || before->recorded_ == 0) {
        reset_.reason = Reset::Reason::first_frame;
        return;
    }
    if (reset_.reason != Reset::Reason::none) return;
    const std::vector<PlanResource>& theirs = before->plan().resources;
    const bool fits =
        before->last_.size.width <= plan().extent.width && before->last_.size.height <= plan().extent.height;
    for (const ResetAction& action : plan().reset) {
        const PlanResource& own = plan().resources[action.resource];
        if (!fits && own.follows) {  // nodes look for the frame before in histories of its size
            reset_for(Reset::Reason::not_handed_on, own);
            inherited_.clear();
            return;
        }
        const auto same = std::ranges::find_if(theirs, [&](const PlanResource& r) {
            return r.lasts() && !is_own(own) && hands_on(r) && hands_on(own) && alike(r, own) &&
                   !before->rested(static_cast<uint32_t>(&r - theirs.data()));
        });
        inherited_.push_back(same == theirs.end()
                                 ? std::nullopt
                                 : std::optional(static_cast<uint32_t>(same - theirs.begin())));
        const bool rests_on = rests(plan().passes[own.first_pass]);  // and begins when it wakes
        if (same == theirs.end() && !action.clear && !rests_on) {
            reset_for(Reset::Reason::not_handed_on, own);
            inherited_.clear();
            return;
        }
    }
}

void ViewState::record_inheritance(VkCommandBuffer cmd) const {
    for (size_t i = 0; i < inherited_.size(); ++i) {
        if (!inherited_[i]) continue;
        const ViewState& before = options_.heir_of->state();
        const ResourceHandles& from = before.memory_.at(*inherited_[i], before.last_.parity);
        const ResourceHandles& to = memory_.at(plan().reset[i].resource, 1 - parity_);
        const PlanResource &r = plan().resources[plan().reset[i].resource],
                           &theirs = before.plan().resources[*inherited_[i]];
        if (!to.image) {  // of sizes that differ the smaller one: what is used lies in front
            const VkBufferCopy copy{0, 0, std::min(r.buffer_bytes(), theirs.buffer_bytes())};
            vk().vkCmdCopyBuffer(cmd, from.buffer, to.buffer, 1, &copy);
            continue;
        }
        const uint32_t width = std::min(r.extent.width, theirs.extent.width),
                       height = std::min(r.extent.height, theirs.extent.height);
        for (uint32_t level = 0; level < std::min(r.levels, theirs.levels); ++level) {
            VkImageCopy copy{};
            copy.srcSubresource = copy.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level, 0, r.layers};
            copy.extent = {std::max(width >> level, 1u), std::max(height >> level, 1u), 1};
            vk().vkCmdCopyImage(cmd, from.image, VK_IMAGE_LAYOUT_GENERAL, to.image, VK_IMAGE_LAYOUT_GENERAL,
                                1, &copy);
        }
    }
}

}  // namespace penumbra
