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
    // Whose view is bound; null for buffers. All its layers and mip levels change their layout and owner, and
    // where a frame writes them lose what they held, whatever the view shows.
    VkImage image = VK_NULL_HANDLE;
    // The host's accesses before the frame and after it. Its writes become visible to the frame's reads;
    // its next accesses wait for what the frame has done. Stages of 0: the host orders that itself, by
    // barriers into the frame's stages and accesses (HostSlot::use) and out of them, between which a layout
    // changes.
    VkPipelineStageFlags2 stages_before = 0, stages_after = 0;
    VkAccessFlags2 access_before = 0, access_after = 0;
    // In between it is in SlotBinding::layout; what the frame writes in VK_IMAGE_LAYOUT_GENERAL.
    VkImageLayout layout_before = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    VkImageLayout layout_after = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    // Queue family ownership, if it is not the frame's: acquired before, released after. The matching half
    // of each transfer is the host's, with the same two layouts; the stages and accesses above are that
    // queue's own then, and a semaphore of the host's orders the two, waited for at HostSlot::use's stages
    // or more. What the frame writes is not acquired and need not be released before: its old contents are
    // lost.
    uint32_t family_before = VK_QUEUE_FAMILY_IGNORED, family_after = VK_QUEUE_FAMILY_IGNORED;
    // 0: those of the slot's format. Of an image that has depth and stencil, whose depth alone is bound, they
    // are to be said: VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT.
    VkImageAspectFlags aspects = 0;
};

// What fills one host slot of this frame; the members that the slot's kind does not use are ignored.
struct SlotBinding {
    VkImageView image = VK_NULL_HANDLE;                               // kind image
    VkImageLayout layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;  // while the frame reads it
    VkBufferView texels = VK_NULL_HANDLE;                             // kind texels
    VkBuffer buffer = VK_NULL_HANDLE;  // kinds buffer and block; of texels where they are handed over
    VkDeviceSize offset = 0, range = VK_WHOLE_SIZE;         // of a block no more than the struct is bound
    VkAccelerationStructureKHR structure = VK_NULL_HANDLE;  // kind structure
    // Empty: it is in `layout` and readable when the frame begins, stays so, and the host orders its own
    // accesses: its writes before this frame's compute stage, its next writes after it.
    std::optional<Handover> handover;
};

// A frame's bindings by name. Made once; record() takes it as it is.
class Externals {
  public:
    explicit Externals(const Plan& plan);            // which outlives it
    SlotBinding& operator[](std::string_view slot);  // throws Failure, with a suggestion, where there is none
    bool has(std::string_view slot) const;
    void clear();                       // as it was made, with nothing bound
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
    // The view that this one replaces, after a change of facts, say. The first frame copies from it, by
    // name, every history that both plans have alike, but of members that slept in its last frame, and clears
    // the others. If one of those must not begin cleared, the first frame is a reset frame. That view stays
    // until this frame has completed; both plans are compiled with hand_on_history. What follows the frame's
    // size may have another largest size here, if that view's last frame fits this plan. Nobody records that
    // view while the first frame is begun here, or after it. A memo that is kept in place is never copied:
    // it may depend on the other plan's parameters.
    const View* heir_of = nullptr;
    void* user = nullptr;  // for host nodes
};

// Why a frame had no history.
struct Reset {
    enum class Reason : uint8_t {
        none,           // it had
        first_frame,    // there was none before
        asked,          // frame_reset in the frame's flags
        not_handed_on,  // the view that this one is the heir of does not have `resource` alike
        woken           // the member of a family that makes `resource` has been asleep
    };
    Reason reason = Reason::none;
    std::string resource;
};

// One instance of a resource.
struct ResourceHandles {
    VkImage image = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    VkBuffer buffer = VK_NULL_HANDLE;
    VkBufferView texels = VK_NULL_HANDLE;
    VkDeviceSize bytes = 0;  // of the buffer
    // Of the image; of an output in one of the host's own, behind the frame, Handover::layout_after.
    VkImageLayout layout = VK_IMAGE_LAYOUT_GENERAL;
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
    // fills it by name); one without a handle is a Failure that names it, with nothing recorded. The first
    // frame, but an heir's, is a reset whatever its flags.
    void record(VkCommandBuffer cmd, const FrameDescription& frame, std::span<const SlotBinding> slots);
    void record(VkCommandBuffer cmd, const FrameDescription& frame, const Externals& slots);

    // The same in parts, for hosts that put passes into separate command buffers of the same queue: begin,
    // every pass in order, end. A frame that was begun and is not ended may be thrown away: the next is begun
    // with frame_reset, without which it is a Failure.
    void begin(VkCommandBuffer cmd, const FrameDescription& frame, std::span<const SlotBinding> slots);
    void begin(VkCommandBuffer cmd, const FrameDescription& frame, const Externals& slots);
    void record_pass(VkCommandBuffer cmd, size_t pass);
    void end(VkCommandBuffer cmd);

    // Sets Plan::passes[pass].params[param] for passes recorded from now on; false if there is none, or if
    // the value is out of range or not of exactly its type (5u for an unsigned one). It is set for this
    // view alone: an heir begins with its own plan's values. Where it is another value than before, what is
    // kept in place to spare work, and follows from it, begins anew in the next frame.
    [[nodiscard]] bool set_param(size_t pass, size_t param, const ParamValue& value);
    // The same by names.
    [[nodiscard]] bool set_param(std::string_view node, std::string_view param, const ParamValue& value);

    // Whether the passes of one of Plan::members run in frames recorded from now on; at first all do. Of one
    // that is asleep, as a lamp that is off, none does but those that hand on what the member before it has
    // left, and what these, other passes and the host read of the others is 0. It wakes without a past: what
    // its passes left before is cleared, and if some of that must not begin cleared, the frame is a reset
    // frame (and View::reset() names it). False: the plan has no such member.
    [[nodiscard]] bool set_awake(std::string_view member, bool awake);

    // The most recently recorded frame's output, from its end() on; before the first, that one's, of which
    // nothing is written yet.
    const ResourceHandles& output(std::string_view name) const;
    // Bytes of a captured resource, tightly packed, after the most recently recorded frame has completed;
    // none before the first.
    std::span<const std::byte> captured(std::string_view name) const;
    // Per pass, after the most recently recorded frame has completed; empty before the first.
    std::vector<PassStatistics> statistics() const;
    // Of the last frame that is known to have completed, which is frames_in_flight before the last one
    // recorded: costs no waiting. Null: there is none yet. A frame whose commands were thrown away is none.
    const FrameStatistics* completed() const;

    // Of the frame that was begun last.
    const Reset& reset() const;

    // Whether enough frame_unchanged frames have been recorded in a row for the plan's histories to settle
    // (Plan::settles). Until something changes the host can keep the last frame's outputs, which another
    // would not improve, and record none. Setting a parameter to another value counts as a change; what host
    // passes keep for themselves only the host can judge.
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
