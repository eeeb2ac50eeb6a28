// SPDX-License-Identifier: MIT
// What a view holds, and how it records. Nothing is allocated while a frame is recorded: what grows per frame
// has been reserved for the plan's largest.
#pragma once

#include <array>
#include <vector>

#include "graph/descriptor_writer.h"
#include "graph/program_state.h"
#include "penumbra/view.h"

namespace penumbra {

class ViewState {
  public:
    ViewState(std::shared_ptr<const Program> program, const ViewOptions& options);

    void begin(VkCommandBuffer cmd, const FrameDescription& frame, std::span<const SlotBinding> slots);
    void record_pass(VkCommandBuffer cmd, size_t pass);
    void end(VkCommandBuffer cmd);
    bool set_param(size_t pass, size_t param, const ParamValue& value);
    bool set_awake(std::string_view member, bool awake);

    const Plan& plan() const { return program_.plan(); }
    // A resource's instance of the frame that was begun last or of the one before; the host's own image where
    // it has lent one.
    const ResourceHandles& instance(uint32_t resource, bool previous) const;
    // Of the last frame that was recorded: one that was begun since may have been thrown away.
    const ResourceHandles& output(uint32_t resource) const;
    const SlotBinding& bound(uint32_t slot) const { return bound_[slot]; }
    std::span<const std::byte> push(size_t pass) const { return push_[pass]; }
    std::span<const std::byte> captured(std::string_view name) const;
    std::vector<PassStatistics> statistics() const;
    const FrameStatistics* completed() const { return has_completed_ ? &completed_ : nullptr; }
    uint64_t bytes() const;
    const Reset& reset() const { return reset_; }
    bool settled() const {
        return plan().settles && recorded_ > 0 && !set_ && next_pass_ == not_begun &&
               unchanged_ >= *plan().settles;
    }

  private:
    struct KeptMemo {
        uint32_t resource;
        std::vector<bool> makers;  // the passes whose parameters it follows from
        bool stale = false;        // one was set since the last frame
    };
    struct Slot {  // one frame in flight
        Held<VkQueryPool> timestamps;
        MappedBuffer frame_block;
        MappedBuffer counters;               // and a word behind them, for has_run()
        std::vector<VkDescriptorSet> sets;   // set 1 of every pass
        std::vector<MappedBuffer> captures;  // parallel to capture_passes_
    };

    const VulkanFunctions& vk() const { return device_.vk(); }
    void make_descriptor_pool();
    VkDescriptorSet allocate_set(size_t pass, size_t set) const;
    void make_internal_sets();
    void write_absent(VkDescriptorSet set, const PlanBinding& b);
    VkDescriptorSet make_internal_set(size_t pass, uint32_t parity, uint32_t level);
    VkImageView view_of(const PlanBinding& b, uint32_t parity, uint32_t level) const;
    void make_slot(Slot& slot);
    void check_slot_bindings(std::span<const SlotBinding> bindings) const;
    void check_slot_binding(const HostSlot& slot, const SlotBinding& binding) const;
    void check_range(const HostSlot& slot, const SlotBinding& binding) const;
    void write_slot_bindings(const Slot& slot);
    const Slot& last_recorded() const { return slots_[(recorded_ - 1) % slots_.size()]; }
    void expect_to_run(const Slot& slot) const;
    bool has_run(const Slot& slot) const;
    void read_statistics(const Slot& slot, std::vector<PassStatistics>& passes,
                         std::vector<uint64_t>& ticks) const;

    bool is_foreign(uint32_t family) const {
        return family != VK_QUEUE_FAMILY_IGNORED && family != device_.handles().queue_family;
    }
    void record_handovers(VkCommandBuffer cmd, bool back);
    void decide_reset(uint32_t flags);
    void decide_waking();
    void reset_for(Reset::Reason reason, const PlanResource& resource);
    void record_reset(VkCommandBuffer cmd);
    void record_inheritance(VkCommandBuffer cmd) const;
    void record_dependency(VkCommandBuffer cmd, const Dependency& dependency);
    void record_clear(VkCommandBuffer cmd, uint32_t resource, uint32_t parity,
                      std::optional<uint32_t> poison) const;
    void record_poison(VkCommandBuffer cmd, size_t pass) const;
    void record_capture(VkCommandBuffer cmd, size_t pass) const;
    void record_host_pass(VkCommandBuffer cmd, size_t pass) const;
    void record_dispatches(VkCommandBuffer cmd, size_t pass) const;
    void record_work(VkCommandBuffer cmd, size_t pass) const;
    bool rests(const PlanPass& pass) const { return pass.rests && resting_[*pass.member]; }
    void record_rest(VkCommandBuffer cmd, const PlanPass& pass) const;
    bool rested(uint32_t resource) const;
    bool is_zero_at_rest(uint32_t resource) const;
    bool wakes(uint32_t resource) const;
    void find_kept_memos();
    bool is_stale(uint32_t resource) const;
    void record_waking(VkCommandBuffer cmd) const;
    void memory_dependency(VkCommandBuffer cmd, const Dependency& dependency,
                           std::span<const VkImageMemoryBarrier2> images = {}) const;
    void full_dependency(VkCommandBuffer cmd, std::span<const VkImageMemoryBarrier2> images = {}) const;

    std::shared_ptr<const Program> keep_alive_;
    const ProgramState& program_;
    const GraphDevice& device_;
    ViewOptions options_;
    PlanMemory memory_;
    Held<VkDescriptorPool> pool_;
    DescriptorWriter writer_;
    // Set 0 by pass, parity and level (one, but for writers of mip chains).
    std::vector<std::array<std::vector<VkDescriptorSet>, 2>> internal_sets_;
    std::vector<Slot> slots_;
    std::vector<KeptMemo> kept_memos_;
    std::vector<size_t> capture_passes_;
    std::vector<std::vector<std::byte>> push_;   // per pass
    std::vector<SlotBinding> bound_;             // of the frame that was begun last
    std::vector<ResourceHandles> lent_;          // by resource: the host's images of this frame
    std::vector<VkImageMemoryBarrier2> images_;  // scratch
    std::vector<VkBufferMemoryBarrier2> buffers_;
    Reset reset_;
    uint32_t unchanged_ = 0;  // frames in a row, to the last one recorded
    bool set_ = false;        // a parameter or who is asleep, since the last frame
    // By member of a family: as the host wants it from the next frame on, in the frame that was begun last,
    // and in the one that was recorded last.
    std::vector<bool> asked_to_rest_, resting_, rested_;
    bool slept_ = false;                              // one of them, in any frame
    std::vector<std::optional<uint32_t>> inherited_;  // by reset action: the resource of the view before
    FrameStatistics completed_;
    bool has_completed_ = false;
    std::vector<uint64_t> ticks_;
    FrameBlock frame_block_{};
    double ms_per_tick_ = 0;  // 0: no timestamps
    uint64_t tick_mask_ = 0;  // the bits of a timestamp that count
    uint64_t recorded_ = 0;   // frames
    struct {
        Extent size;
        uint32_t parity = 0;
        std::vector<ResourceHandles> lent;
    } last_;       // of them
    Extent size_;  // of the frame that was begun last, like all that follows
    uint32_t parity_ = 0;
    uint32_t slot_ = 0;
    static constexpr size_t not_begun = ~size_t{0};
    size_t next_pass_ = not_begun;
};

}  // namespace penumbra
