// SPDX-License-Identifier: MIT
// What is wrong with what a host binds to its slots, said before anything is recorded: what Vulkan would say
// of it would not name the slot, and without validation would say nothing.
#include <fmt/format.h>

#include "graph/view_state.h"

namespace penumbra {
namespace {

// Layouts in which no shader may read an image. Those of extensions are the host's to know.
bool is_unreadable(VkImageLayout layout) {
    switch (layout) {
        case VK_IMAGE_LAYOUT_UNDEFINED:
        case VK_IMAGE_LAYOUT_PREINITIALIZED:
        case VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL:
        case VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL:
        case VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL:
        case VK_IMAGE_LAYOUT_STENCIL_ATTACHMENT_OPTIMAL:
        case VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL:
        case VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL:
        case VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL:
        case VK_IMAGE_LAYOUT_PRESENT_SRC_KHR:
            return true;
        default:
            return false;
    }
}

bool is_bound(PortKind kind, const SlotBinding& b) {
    switch (kind) {
        case PortKind::image:
            return b.image != VK_NULL_HANDLE;
        case PortKind::texels:
            return b.texels != VK_NULL_HANDLE;
        case PortKind::structure:
            return b.structure != VK_NULL_HANDLE;
        default:
            return b.buffer != VK_NULL_HANDLE;
    }
}

bool is_same(PortKind kind, const SlotBinding& a, const SlotBinding& b) {
    return kind == PortKind::image ? a.handover->image == b.handover->image
                                   : a.buffer == b.buffer && a.offset == b.offset && a.range == b.range;
}

[[noreturn]] void wrong(const HostSlot& slot, const std::string& text) {
    fail(ErrorCode::usage, fmt::format("the slot \"{}\"", slot.name), text);
}

bool same_transitions(PortKind kind, const SlotBinding& a, const SlotBinding& b) {
    const Handover &x = *a.handover, &y = *b.handover;
    const bool families = x.family_before == y.family_before && x.family_after == y.family_after;
    return kind != PortKind::image ? families
                                   : families && a.layout == b.layout && x.layout_before == y.layout_before &&
                                         x.layout_after == y.layout_after && x.aspects == y.aspects;
}

// What fills two slots is handed over alike, and is in neither what a frame writes.
void check_together(const HostSlot& slot, const SlotBinding& b, const HostSlot& other,
                    const SlotBinding& bound) {
    const bool image = slot.kind == PortKind::image, written = other.output || slot.output;
    if ((other.kind == PortKind::image) != image) return;
    const bool handed_over = b.handover && bound.handover && is_same(slot.kind, b, bound);
    if (written && (handed_over || b.image == bound.image))
        wrong(slot, fmt::format("its image is bound as \"{}\", too, and one of them is written", other.name));
    if (handed_over && !same_transitions(slot.kind, b, bound))
        wrong(slot, fmt::format("its {} is handed over as \"{}\", too, and otherwise",
                                image ? "image" : "buffer", other.name));
}

}  // namespace

void ViewState::check_slot_bindings(std::span<const SlotBinding> bindings) const {
    if (bindings.size() != plan().slots.size())
        fail(ErrorCode::usage, plan().pipeline,
             fmt::format("{} slots were bound, the plan has {}", bindings.size(), plan().slots.size()));
    const std::vector<HostSlot>& slots = plan().slots;
    for (size_t i = 0; i < bindings.size(); ++i) {
        check_slot_binding(slots[i], bindings[i]);
        for (size_t before = 0; before < i; ++before)
            check_together(slots[i], bindings[i], slots[before], bindings[before]);
    }
}

void ViewState::check_slot_binding(const HostSlot& slot, const SlotBinding& b) const {
    if (!is_bound(slot.kind, b))
        wrong(slot, slot.required ? "nothing is bound to it"
                                  : "nothing is bound to it, and the plan was not told that it is left out");
    if (slot.kind == PortKind::image && !slot.output && is_unreadable(b.layout))
        wrong(slot, "no shader reads an image in this layout (SlotBinding::layout)");
    if (slot.kind == PortKind::block || slot.kind == PortKind::buffer) check_range(slot, b);
    if (slot.output && !b.handover)
        wrong(slot, "an image that is written is handed over (SlotBinding::handover)");
    if (!b.handover) return;
    if (slot.kind == PortKind::structure) wrong(slot, "an acceleration structure cannot be handed over");
    if (slot.kind == PortKind::image ? b.handover->image == VK_NULL_HANDLE : b.buffer == VK_NULL_HANDLE)
        wrong(slot, "what is handed over is not named (Handover::image, SlotBinding::buffer)");
    const size_t families = device_.queue_families().size();
    for (const uint32_t family : {b.handover->family_before, b.handover->family_after})
        if (family >= families && family < VK_QUEUE_FAMILY_FOREIGN_EXT)  // and what lies above it
            wrong(slot,
                  fmt::format("is handed over by queue family {}, and there are {} (Handover::family_before, "
                              "family_after)",
                              family, families));
    if (slot.kind == PortKind::texels && b.range == 0) wrong(slot, "a range of 0 bytes is handed over");
    if (slot.kind != PortKind::image) return;
    if (!slot.output && b.handover->layout_before == VK_IMAGE_LAYOUT_UNDEFINED)
        wrong(slot, "is read, and a Handover::layout_before of UNDEFINED would lose what it holds");
    if (b.handover->layout_after == VK_IMAGE_LAYOUT_UNDEFINED)
        wrong(slot, "an image cannot be handed back in UNDEFINED (Handover::layout_after)");
}

void ViewState::check_range(const HostSlot& slot, const SlotBinding& b) const {
    const VkPhysicalDeviceLimits& limits = device_.properties().limits;
    const bool block = slot.kind == PortKind::block;
    const VkDeviceSize alignment =
        block ? limits.minUniformBufferOffsetAlignment : limits.minStorageBufferOffsetAlignment;
    if (b.range == 0) wrong(slot, "a range of 0 bytes is bound to it");
    if (block && b.range < slot.bytes)
        wrong(slot, fmt::format("{} bytes are bound to it, of a block of {}", b.range, slot.bytes));
    if (b.offset % alignment != 0)
        wrong(slot, fmt::format("an offset of {} is bound to it, which is no multiple of the device's {}",
                                b.offset, alignment));
}

}  // namespace penumbra
