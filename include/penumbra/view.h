// SPDX-License-Identifier: MIT
// One camera's use of a program: memory, history, descriptors, frames in flight. record() writes commands
// into the host's command buffer; it submits nothing, waits for nothing and owns no thread.
//
// The host promises: one queue, frames submitted in the order they were recorded, and that frame f -
// frames_in_flight has completed when frame f is recorded. Outputs are valid until the next record() of the
// same view.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "penumbra/export.h"
#include "penumbra/frame_block.h"
#include "penumbra/program.h"

namespace PENUMBRA_API penumbra {

// What fills one host slot of this frame; the members that the slot's kind does not use are ignored.
struct SlotBinding {
    VkImageView image = VK_NULL_HANDLE;  // kind image
    VkImageLayout layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    VkBufferView texels = VK_NULL_HANDLE;  // kind texels
    VkBuffer buffer = VK_NULL_HANDLE;      // kinds buffer and block
    VkDeviceSize offset = 0, range = VK_WHOLE_SIZE;
    VkAccelerationStructureKHR structure = VK_NULL_HANDLE;  // kind structure
};

struct ViewOptions {
    uint32_t frames_in_flight = 2;
    // Fills every activated resource before its first use: floats with NaN, unorm with 0.7312 and words with
    // 0xDEADBEEF for pattern 0; other values for pattern 1. The plan must have been compiled with
    // CompileOptions::poison.
    std::optional<uint32_t> poison;
};

// What a host node's callback is given.
struct HostPassContext {
    VkCommandBuffer cmd = VK_NULL_HANDLE;
    const PlanPass* pass = nullptr;
    // Image and buffer bound to a port in this frame (internal resources; null handles for host slots).
    std::function<const ResourceInstance*(std::string_view port)> resource;
    const FrameBlock* frame = nullptr;
};

struct PassStatistics {
    std::optional<double> ms;        // GPU timestamps; nothing where the queue has none
    std::vector<uint32_t> counters;  // in the declaration's order
};

class View {
  public:
    View(std::shared_ptr<const Program> program, const ViewOptions& options);

    // Records the whole frame. `slots` is parallel to Plan::slots; one without a handle is a VulkanError that
    // names it. The first frame is a reset frame whatever its flags. The host orders its own accesses to what
    // it binds: writes before the compute stage's reads of this frame, and the next frame's writes after
    // them.
    void record(VkCommandBuffer cmd, const FrameDescription& frame, std::span<const SlotBinding> slots);

    // The same in parts, for hosts that put passes into separate command buffers of the same queue, in order:
    // begin, every pass, end.
    void begin(VkCommandBuffer cmd, const FrameDescription& frame, std::span<const SlotBinding> slots);
    void record_pass(VkCommandBuffer cmd, size_t pass);
    void end(VkCommandBuffer cmd);

    // The value of a parameter of Plan::passes[pass].params from the next frame on; false where it is not of
    // its type and range.
    bool set_param(size_t pass, size_t param, const ParamValue& value);
    // The same by names; also false where there is no such node or dynamic parameter.
    bool set_param(std::string_view node, std::string_view param, const ParamValue& value);

    // The most recently recorded frame's output (its image stays in VK_IMAGE_LAYOUT_GENERAL).
    const ResourceInstance& output(std::string_view name) const;
    // Bytes of a captured resource, tightly packed, after the most recently recorded frame has completed.
    std::span<const std::byte> captured(std::string_view name) const;
    // Per pass, after the most recently recorded frame has completed.
    std::vector<PassStatistics> statistics() const;

    const Plan& plan() const { return program_->plan(); }

  private:
    struct Slot {  // one frame in flight
        Owned<VkQueryPool> timestamps;
        MappedBuffer frame_block, counters;
        std::vector<VkDescriptorSet> sets;   // set 1 of every pass
        std::vector<MappedBuffer> captures;  // parallel to capture_passes_
    };

    class Writer;
    void make_descriptor_pool();
    VkDescriptorSet allocate_set(size_t pass, size_t set) const;
    void make_internal_sets();
    void write_absent(Writer& writer, VkDescriptorSet set, const PlanBinding& b) const;
    VkDescriptorSet make_internal_set(size_t pass, uint32_t parity, uint32_t level);
    void record_dispatches(VkCommandBuffer cmd, size_t pass) const;
    void make_slot(Slot& slot);
    void check_slot_bindings(std::span<const SlotBinding> bindings) const;
    void write_slot_bindings(const Slot& slot, std::span<const SlotBinding> bindings);
    void record_reset(VkCommandBuffer cmd);
    void record_dependency(VkCommandBuffer cmd, const Dependency& dependency) const;
    void record_clear(VkCommandBuffer cmd, uint32_t resource, uint32_t parity,
                      std::optional<uint32_t> poison) const;
    void record_poison(VkCommandBuffer cmd, size_t pass) const;
    void record_capture(VkCommandBuffer cmd, size_t pass) const;
    void record_host_pass(VkCommandBuffer cmd, size_t pass) const;
    const ResourceInstance& instance(const PlanBinding& binding) const;

    std::shared_ptr<const Program> program_;
    ViewOptions options_;
    PlanMemory memory_;
    Owned<VkDescriptorPool> pool_;
    // Set 0 by pass, parity and level (one, but for writers of mip chains).
    std::vector<std::array<std::vector<VkDescriptorSet>, 2>> internal_sets_;
    std::vector<Slot> slots_;
    std::vector<size_t> capture_passes_;
    std::vector<std::vector<std::byte>> push_;  // per pass
    FrameBlock frame_block_{};
    double ms_per_tick_ = 0;  // 0: no timestamps
    uint64_t tick_mask_ = 0;  // the bits of a timestamp that count
    uint64_t recorded_ = 0;   // frames
    uint32_t parity_ = 0;
    uint32_t slot_ = 0;
    PFN_vkCmdBeginDebugUtilsLabelEXT begin_label_ = nullptr;
    PFN_vkCmdEndDebugUtilsLabelEXT end_label_ = nullptr;
};

}  // namespace penumbra
