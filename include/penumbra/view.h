// SPDX-License-Identifier: MIT
// One camera's use of a program: memory, history, descriptors, frames in flight. record() writes commands
// into the host's command buffer; it submits nothing, waits for nothing and owns no thread. Views are
// independent of each other: each may be recorded on a thread of its own.
//
// The host promises: one queue, frames submitted in the order they were recorded, and that frame f -
// frames_in_flight has completed when frame f is recorded. Outputs are valid until the next record() of the
// same view. After commands that are thrown away instead of submitted, the next frame is recorded with
// frame_reset.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "penumbra/export.h"
#include "penumbra/frame_block.h"
#include "penumbra/program.h"

namespace penumbra PENUMBRA_API {

// How the host hands something over for a frame, and how it wants it back. Where a member says that nothing
// changes, nothing is recorded for it.
struct Handover {
    VkImage image = VK_NULL_HANDLE;  // whose view is bound; null for buffers
    // Before the frame, and behind it. What the host has written is made visible to the frame's reads of it;
    // what the frame has done comes before the host's next accesses. Stages of 0: the host orders that
    // itself.
    VkPipelineStageFlags2 stages_before = 0, stages_after = 0;
    VkAccessFlags2 access_before = 0, access_after = 0;
    // In between it is in SlotBinding::layout; what the frame writes in VK_IMAGE_LAYOUT_GENERAL.
    VkImageLayout layout_before = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    VkImageLayout layout_after = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    // The queue family that owns it, where it is not the frame's: acquired before, released behind. The
    // other half of each transfer is the host's, with the same two layouts.
    uint32_t family_before = VK_QUEUE_FAMILY_IGNORED, family_after = VK_QUEUE_FAMILY_IGNORED;
    VkImageAspectFlags aspects = 0;  // 0: as the format has them; of a depth-stencil image both
};

// What fills one host slot of this frame; the members that the slot's kind does not use are ignored.
struct SlotBinding {
    VkImageView image = VK_NULL_HANDLE;                               // kind image
    VkImageLayout layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;  // while the frame reads it
    VkBufferView texels = VK_NULL_HANDLE;                             // kind texels
    VkBuffer buffer = VK_NULL_HANDLE;  // kinds buffer and block; of texels where they are handed over
    VkDeviceSize offset = 0, range = VK_WHOLE_SIZE;
    VkAccelerationStructureKHR structure = VK_NULL_HANDLE;  // kind structure
    // Nothing: it is readable when the frame comes, stays as it is, and the host orders its own accesses:
    // writes before the compute stage's reads of this frame, and the next frame's writes after them.
    std::optional<Handover> handover;
};

// A frame's bindings by name. Made once; record() takes it as it is.
class Externals {
  public:
    explicit Externals(const Plan& plan);            // which outlives it
    SlotBinding& operator[](std::string_view slot);  // throws Failure, with a suggestion, where there is none
    bool has(std::string_view slot) const;
    bool fits(const Plan& plan) const;  // whether that one has the same slots
    operator std::span<const SlotBinding>() const { return bindings_; }

  private:
    const Plan* plan_;
    std::vector<SlotBinding> bindings_;
};

class View;

struct ViewOptions {
    uint32_t frames_in_flight = 2;
    // Fills every activated resource before its first use: floats with NaN, unorm and snorm with 0.7312 and
    // words with 0xDEADBEEF for pattern 0; other values for pattern 1. The plan must have been compiled with
    // CompileOptions::poison.
    std::optional<uint32_t> poison;
    bool timestamps = true;        // two queries per pass; not where the queue has none
    bool tables_uploaded = false;  // Program::record_uploads() runs before this view's first frame
    // Where shared heaps lie; null: in memory of this view's own. Such views run one after another, and each
    // frame waits for what is in them.
    std::shared_ptr<const TransientMemory> transients;
    // The view whose place this one takes, with other facts, say: what its last frame has left for the next
    // one is copied in this one's first frame, by name, where both plans have it alike, and what this plan
    // has besides is cleared. Where something is wanted that is neither, the first frame is a reset frame.
    // That view stays until this frame has completed; both plans hand on their history (CompileOptions). What
    // follows the frame's size may be larger or smaller here, where the last frame's size is one of this
    // plan's. A memo that is kept in place is never handed on: it may be what that plan's parameters made of
    // it.
    const View* heir_of = nullptr;
    void* user = nullptr;  // for host nodes
};

// Why a frame had no history.
struct Reset {
    enum class Reason : uint8_t {
        none,          // it had
        first_frame,   // there was none before
        asked,         // frame_reset in the frame's flags
        not_handed_on  // the view that this one is the heir of does not have `resource` alike
    };
    Reason reason = Reason::none;
    std::string resource;
};

// One instance of a resource; its images are in VK_IMAGE_LAYOUT_GENERAL.
struct ResourceHandles {
    VkImage image = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    VkBuffer buffer = VK_NULL_HANDLE;
    VkBufferView texels = VK_NULL_HANDLE;
    VkDeviceSize bytes = 0;  // of the buffer
};

class ViewState;

// What a host node's callback is given.
struct HostPassContext {
    VkCommandBuffer cmd = VK_NULL_HANDLE;
    const PlanPass* pass = nullptr;
    const FrameBlock* frame = nullptr;
    void* user = nullptr;             // ViewOptions::user
    const ViewState* view = nullptr;  // for the functions below

    // What a port is bound to in this frame: a resource of the plan, or what the host has bound; null:
    // neither.
    const ResourceHandles* resource(std::string_view port) const;
    const SlotBinding* slot(std::string_view port) const;
    // A parameter's value in this view; nothing where there is none of this name.
    std::optional<ParamValue> param(std::string_view name) const;
};

struct PassStatistics {
    std::optional<double> ms;        // GPU timestamps; nothing where there are none
    std::vector<uint32_t> counters;  // in the declaration's order
};

struct FrameStatistics {
    uint64_t frame = 0;  // counted from 0 by record()
    std::vector<PassStatistics> passes;
};

class View {
  public:
    // Throws Failure.
    View(std::shared_ptr<const Program> program, const ViewOptions& options);
    ~View();
    View(const View&) = delete;
    View& operator=(const View&) = delete;

    // Records the whole frame, of any size up to the plan's. `slots` is parallel to Plan::slots (Externals
    // fills it by name); one without a handle is a Failure that names it, and nothing has been recorded then.
    // The first frame is a reset frame whatever its flags.
    void record(VkCommandBuffer cmd, const FrameDescription& frame, std::span<const SlotBinding> slots);
    void record(VkCommandBuffer cmd, const FrameDescription& frame, const Externals& slots);

    // The same in parts, for hosts that put passes into separate command buffers of the same queue: begin,
    // every pass in order, end. A frame that was begun and is not ended may be thrown away: the next is begun
    // with frame_reset, without which it is a Failure.
    void begin(VkCommandBuffer cmd, const FrameDescription& frame, std::span<const SlotBinding> slots);
    void begin(VkCommandBuffer cmd, const FrameDescription& frame, const Externals& slots);
    void record_pass(VkCommandBuffer cmd, size_t pass);
    void end(VkCommandBuffer cmd);

    // The value of a parameter of Plan::passes[pass].params, of passes that are recorded from now on; false
    // where there is none or the value is not of its range and very type (5u of an unsigned one). What was
    // set is this view's: its heir begins with the values of its own plan.
    [[nodiscard]] bool set_param(size_t pass, size_t param, const ParamValue& value);
    // The same by names.
    [[nodiscard]] bool set_param(std::string_view node, std::string_view param, const ParamValue& value);

    // The most recently recorded frame's output; before the first, that one's, of which nothing is written
    // yet.
    const ResourceHandles& output(std::string_view name) const;
    // Bytes of a captured resource, tightly packed, after the most recently recorded frame has completed;
    // none before the first.
    std::span<const std::byte> captured(std::string_view name) const;
    // Per pass, after the most recently recorded frame has completed; empty before the first.
    std::vector<PassStatistics> statistics() const;
    // Of the last frame that is known to have completed, which is frames_in_flight before the last one
    // recorded: costs no waiting. Null: there is none yet.
    const FrameStatistics* completed() const;

    // Of the most recently recorded frame.
    const Reset& reset() const;

    // Whether as many frames of frame_unchanged have been recorded, one after the other, as the plan's pasts
    // take to settle (Plan::settles): a host to which nothing changes keeps the outputs of the last frame,
    // which another one would make no better, and records none. A parameter that is set is a change; of what
    // a host's own passes keep for themselves, the host alone knows whether it changes.
    bool settled() const;

    const Plan& plan() const;
    // Allocated for this view alone: its heaps (without shared ones), what the host writes per frame in
    // flight, captures.
    uint64_t bytes() const;

    const ViewState& state() const { return *state_; }  // its heir's

  private:
    std::unique_ptr<ViewState> state_;
};

}  // namespace penumbra
