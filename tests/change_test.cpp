// SPDX-License-Identifier: MIT
// Facts and sizes change while frames are in flight: what goes on, what starts anew, and that nobody waits.
#include <random>

#include "tests/embedding_host.h"
#include "tests/sized_run.h"
#include "tests/toy_nodes.h"

namespace penumbra::test {
namespace {

class ChangeGpu : public GpuTest {};

// Facts change every few frames: each time another plan's view takes over, and all histories (an image, what
// is kept) go on as if there had been but one.
TEST_F(ChangeGpu, AnHeirGoesOnWhereTheViewBeforeHasStopped) {
    const CheckedPipeline pipeline = checked(R"("outputs": ["blended", "tally", "trail", "level"], "nodes": {
        "fill": { "type": "toy_fill" }, "tally": { "type": "toy_tally" },
        "blend": { "type": "toy_blend", "in": { "history": "blended@-1" } },
        "bright": { "type": "toy_fill", "if": "moves", "params": { "scale": 3 }, "out": { "value": "level" } },
        "dim": { "type": "toy_fill", "if": "!moves", "out": { "value": "level" } } })");
    const std::shared_ptr<const Program> day = program_with(pipeline, {}),
                                         night = program_with(pipeline, {{"moves", false}});
    View alone(day, {});
    auto view = std::make_unique<View>(day, ViewOptions{});
    std::vector<std::unique_ptr<View>> retired;
    for (uint32_t f = 0; f < 12; ++f) {
        if (f == 3 || f == 4 || f == 8) {
            const auto& next = &view->plan() == &day->plan() ? night : day;
            auto heir = std::make_unique<View>(next, ViewOptions{.heir_of = view.get()});
            retired.push_back(std::move(view));
            view = std::move(heir);
        }
        gpu().run([&](VkCommandBuffer cmd) { view->record(cmd, description(f), {}); });
        gpu().run([&](VkCommandBuffer cmd) { alone.record(cmd, description(f), {}); });
        EXPECT_EQ(view->reset().reason, f == 0 ? Reset::Reason::first_frame : Reset::Reason::none) << f;
        for (const char* name : {"blended", "tally", "trail"})
            EXPECT_EQ(floats(view->captured(name)), floats(alone.captured(name))) << name << " " << f;
        const bool moves = &view->plan() == &day->plan();
        EXPECT_EQ(floats(view->captured("level"))[2], (moves ? 3 : 1) * 2.0f + static_cast<float>(f)) << f;
    }
    // An heir whose first frame is a cut takes nothing over.
    View cut(day, {.heir_of = view.get()});
    FrameDescription first = description(12);
    first.flags = frame_reset;
    gpu().run([&](VkCommandBuffer cmd) { cut.record(cmd, first, {}); });
    EXPECT_EQ(cut.reset().reason, Reset::Reason::asked);
    EXPECT_EQ(floats(cut.captured("blended"))[5], 17.0f);  // the value alone
}

// What an heir begins with was made by another plan, perhaps of another size: its first frame is like none
// before.
TEST_F(ChangeGpu, AnHeirHasToSettleAnew) {
    const auto program = program_with(checked(R"("outputs": ["blended"], "nodes": {
        "fill": { "type": "toy_fill" }, "blend": { "type": "toy_blend", "in": { "history": "value@-1" } } })"),
                                      {});
    ASSERT_EQ(program->plan().settles, 1u) << "of the frame before, which does not feed itself";
    const auto settled_after = [](View& view, uint32_t f) {
        FrameDescription frame = description(f);
        frame.flags = frame_unchanged;
        gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, frame, {}); });
        return view.settled();
    };
    View before(program, {});
    EXPECT_FALSE(settled_after(before, 0));
    EXPECT_TRUE(settled_after(before, 1));
    View heir(program, {.heir_of = &before});
    EXPECT_FALSE(settled_after(heir, 2));
    EXPECT_EQ(heir.reset().reason, Reset::Reason::none);
    EXPECT_TRUE(settled_after(heir, 3));
}

// A frame that was begun and never ended: outputs, and what an heir goes on from, are those of the last one
// recorded, of its size.
TEST_F(ChangeGpu, WhatWasThrownAwayIsNoPast) {
    const auto program = program_with(checked(R"("outputs": ["blended"], "nodes": {
        "fill": { "type": "toy_fill" }, "blend": { "type": "toy_blend", "in": { "history": "value@-1" } } })"),
                                      {});
    View alone(program, {}), before(program, {});
    for (uint32_t f = 0; f < 4; ++f) {
        FrameDescription frame = description(f);
        frame.flags = frame_unchanged;
        for (View* view : {&alone, &before})
            gpu().run([&](VkCommandBuffer cmd) { view->record(cmd, frame, {}); });
    }
    const VkImage last = before.output("blended").image;
    EXPECT_TRUE(before.settled());
    Recorder never_run;
    never_run.record([&](VkCommandBuffer cmd) {
        before.begin(cmd, description(4, {9, 8}), std::span<const SlotBinding>{});
    });
    EXPECT_EQ(before.output("blended").image, last);
    EXPECT_FALSE(before.settled()) << "the next is a reset";
    View heir(program, {.heir_of = &before});
    for (View* view : {&alone, &heir})
        gpu().run([&](VkCommandBuffer cmd) { view->record(cmd, description(4), {}); });
    EXPECT_EQ(floats(heir.captured("blended")), floats(alone.captured("blended")));
}

TEST_F(ChangeGpu, AnHeirWithoutItsHistoryStartsAnewAndSaysWhy) {
    const CheckedPipeline first =
                              checked(R"("outputs": ["value"], "nodes": { "fill": { "type": "toy_fill" } })"),
                          second =
                              checked(R"("outputs": ["blended"], "nodes": { "fill": { "type": "toy_fill" },
        "blend": { "type": "toy_blend", "in": { "history": "blended@-1" } } })");
    // A "blended" of another format, as large in memory; and one that is kept in place, which is no history.
    NodeSet set;
    const auto add = [&](const std::string& name, const std::string& ports) {
        NodeEntry other;
        other.type =
            parse_toy("{ \"node\": \"" + name + "\", \"doc\": \"d\", \"host\": true, " + ports + " }", name);
        other.callback = [](const HostPassContext&) {};
        set.add(std::move(other));
    };
    add("other", R"("inputs": { "history": { "kind": "image", "format": "rg16f", "previous": true } },
      "outputs": { "blended": { "kind": "image", "format": "rg16f" } })");
    add("keeper", R"("inputs": {},
      "outputs": { "blended": { "kind": "image", "format": "r32f", "writes": "kept" } })");
    const CheckedPipeline third = checked(
        R"("outputs": ["blended"], "nodes": { "other": { "type": "other", "in": { "history": "blended@-1" } } })",
        set);
    const CheckedPipeline fourth =
        checked(R"("outputs": ["blended"], "nodes": { "keeper": { "type": "keeper" } })", set);
    const std::shared_ptr<const Program> heirs = program_with(second, {});
    const std::shared_ptr<const Program> before_them[] = {
        program_with(third, {}), program_with(fourth, {}), program_with(first, {}),  // the last has none
        program_with(second, {}, true, {width + 1, height}),                         // has another size
        program_with(second, {}, false)};                                            // does not hand it on
    for (const auto& program : before_them) {
        View before(program, {});
        FrameDescription frame = description(0);
        frame.size = frame.prev_size = {program->plan().extent.width, program->plan().extent.height};
        gpu().run([&](VkCommandBuffer cmd) { before.record(cmd, frame, {}); });
        View after(heirs, {.heir_of = &before});
        gpu().run([&](VkCommandBuffer cmd) { after.record(cmd, description(1), {}); });
        EXPECT_EQ(after.reset().reason, Reset::Reason::not_handed_on);
        EXPECT_EQ(after.reset().resource, "blended");
        EXPECT_EQ(floats(after.captured("blended"))[5], 6.0f);  // the value alone
        gpu().run([&](VkCommandBuffer cmd) { after.record(cmd, description(2), {}); });
        EXPECT_EQ(after.reset().reason, Reset::Reason::none);
        FrameDescription cut = description(3);
        cut.flags = frame_reset;
        gpu().run([&](VkCommandBuffer cmd) { after.record(cmd, cut, {}); });
        EXPECT_EQ(after.reset().reason, Reset::Reason::asked);
    }
    View unused(heirs, {});
    View after(heirs, {.heir_of = &unused});
    gpu().run([&](VkCommandBuffer cmd) { after.record(cmd, description(0), {}); });
    EXPECT_EQ(after.reset().reason, Reset::Reason::first_frame);
}

// A frame that the new plan is too small for is no past that a node could look into, also where nothing
// has to be handed on.
TEST_F(ChangeGpu, AnHeirOfALargerFrameStartsAnew) {
    const CheckedPipeline pipeline = checked(
        R"("outputs": ["blended"], "resources": { "blended": { "first": "clear" } }, "nodes": {
        "fill": { "type": "toy_fill" }, "blend": { "type": "toy_blend", "in": { "history": "blended@-1" } } })");
    const auto large = program_with(pipeline, {}, true, {2 * width, height}),
               small = program_with(pipeline, {});
    for (const Extent size : {Extent{2 * width, height}, Extent{width, height}}) {
        View before(large, {});
        gpu().run([&](VkCommandBuffer cmd) { before.record(cmd, description(0, size), {}); });
        View after(small, {.heir_of = &before});
        gpu().run([&](VkCommandBuffer cmd) { after.record(cmd, description(1), {}); });
        const bool fits = size.width == width;
        EXPECT_EQ(after.reset().reason, fits ? Reset::Reason::none : Reset::Reason::not_handed_on);
        EXPECT_EQ(after.reset().resource, fits ? "" : "blended");
        EXPECT_EQ(floats(after.captured("blended"))[5], fits ? 8.5f : 6.0f);
    }
}

// The heir of a view that has recorded nothing has no frame before it, and no camera of one.
TEST_F(ChangeGpu, AnHeirOfNothingNeedsNoCameraBefore) {
    const auto program = program_with(checked(R"("outputs": ["blended"], "nodes": {
        "fill": { "type": "toy_fill" }, "blend": { "type": "toy_blend", "in": { "history": "blended@-1" } } })"),
                                      {});
    View before(program, {}), heir(program, {.heir_of = &before});
    FrameDescription frame = description(0);
    frame.camera.clip_from_view = perspective(1, 1, 0.1);
    frame.previous.clip_from_view = {};
    gpu().run([&](VkCommandBuffer cmd) { heir.record(cmd, frame, {}); });
    EXPECT_EQ(heir.reset().reason, Reset::Reason::first_frame);
}

// Between plans for frames of several sizes a history that follows the frame goes over as far as both have
// it: a buffer's beginning, every level of a chain.
TEST_F(ChangeGpu, BuffersAndChainsGoOverAsFarAsBothHaveThem) {
    static const GpuBuffer read = make_host_buffer(gpu(), 16, VK_BUFFER_USAGE_TRANSFER_DST_BIT, "read");
    NodeSet set;
    NodeEntry keeper;
    keeper.type = parse_toy(R"({ "node": "keeper", "doc": "d", "host": true,
      "inputs": { "cells_prev": { "kind": "buffer", "element": "u32", "previous": true },
                  "chain_prev": { "kind": "image", "format": "r32f", "levels": true, "previous": true } },
      "outputs": { "cells": { "kind": "buffer", "element": "u32", "count": { "of": "frame", "div": [1, 1] } },
                   "chain": { "kind": "image", "format": "r32f", "levels": true } } })",
                            "keeper");
    keeper.callback = [](const HostPassContext& context) {
        const auto index = context.frame->frame_index;
        if (index == 0) {
            vkCmdFillBuffer(context.cmd, context.resource("cells")->buffer, 0, VK_WHOLE_SIZE, 1234);
            const VkClearColorValue colour{.float32 = {5}};
            const VkImageSubresourceRange third{VK_IMAGE_ASPECT_COLOR_BIT, 2, 1, 0, 1};
            vkCmdClearColorImage(context.cmd, context.resource("chain")->image, VK_IMAGE_LAYOUT_GENERAL,
                                 &colour, 1, &third);
            return;
        }
        const VkBufferCopy cells{0, 0, 8};
        vkCmdCopyBuffer(context.cmd, context.resource("cells_prev")->buffer, read.get(), 1, &cells);
        VkBufferImageCopy texel{};
        texel.bufferOffset = 8;
        texel.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 2, 0, 1};
        texel.imageExtent = {1, 1, 1};
        vkCmdCopyImageToBuffer(context.cmd, context.resource("chain_prev")->image, VK_IMAGE_LAYOUT_GENERAL,
                               read.get(), 1, &texel);
    };
    set.add(std::move(keeper));
    const CheckedPipeline pipeline = checked(
        R"("outputs": ["cells", "chain"], "nodes": { "keeper": { "type": "keeper",
           "in": { "cells_prev": "cells@-1", "chain_prev": "chain@-1" } } })",
        set);
    constexpr Extent small{12, 8}, large{29, 13};
    for (const Extent from : {small, large}) {
        View before(program_with(pipeline, {}, true, from), {});
        gpu().run([&](VkCommandBuffer cmd) { before.record(cmd, description(0, small), {}); });
        const Extent to = from.width == small.width ? large : small;
        View heir(program_with(pipeline, {}, true, to), {.heir_of = &before});
        std::memset(read.mapped, 0, 16);
        gpu().run([&](VkCommandBuffer cmd) { heir.record(cmd, description(1, small), {}); });
        EXPECT_EQ(heir.reset().reason, Reset::Reason::none);
        uint32_t cells[2];
        float texel;
        std::memcpy(cells, read.mapped, 8);
        std::memcpy(&texel, static_cast<const std::byte*>(read.mapped) + 8, 4);
        EXPECT_EQ(cells[1], 1234u) << to.width;
        EXPECT_EQ(texel, 5.0f) << to.width;
    }
}

// A node that keeps two words in place, one a memo: 1234 from frame 0 on, of which later frames tell `read`.
NodeSet keeper_set(const GpuBuffer& read) {
    NodeSet set = toy_set();
    NodeEntry keeper;
    keeper.type = parse_toy(R"({ "node": "keeper", "doc": "d", "host": true, "inputs": {},
      "outputs": { "cells": { "kind": "buffer", "element": "u32", "count": { "of": "frame" }, "writes": "kept" },
                   "memo": { "kind": "buffer", "element": "u32", "count": { "of": "frame" }, "writes": "kept", "memo": true } },
      "params": { "seed": { "type": "uint", "default": 1, "doc": "d" } } })",
                            "keeper");
    keeper.callback = [&read](const HostPassContext& context) {
        for (const char* name : {"cells", "memo"}) {
            const VkBuffer buffer = context.resource(name)->buffer;
            const VkBufferCopy first{0, name[0] == 'c' ? 0u : 4u, 4};
            if (context.frame->frame_index == 0)
                vkCmdFillBuffer(context.cmd, buffer, 0, VK_WHOLE_SIZE, 1234);
            else
                vkCmdCopyBuffer(context.cmd, buffer, read.get(), 1, &first);
        }
    };
    set.add(std::move(keeper));
    return set;
}

using Kept = std::array<uint32_t, 2>;

Kept kept_in(View& view, uint32_t f, const GpuBuffer& read) {
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(f), {}); });
    Kept kept{};
    std::memcpy(kept.data(), read.mapped, sizeof kept);
    return kept;
}

// What is kept in place goes over, but for a memo, which may be what another plan's parameters made of it.
TEST_F(ChangeGpu, AKeptMemoIsNotHandedOn) {
    const GpuBuffer read = make_host_buffer(gpu(), 8, VK_BUFFER_USAGE_TRANSFER_DST_BIT, "read");
    const auto program =
        program_with(checked(R"("outputs": ["cells", "memo"], "nodes": { "keeper": { "type": "keeper" } })",
                             keeper_set(read)),
                     {});
    View before(program, {});
    kept_in(before, 0, read);
    View heir(program, {.heir_of = &before});
    EXPECT_EQ(kept_in(heir, 1, read), (Kept{1234, 0}));
    EXPECT_EQ(heir.reset().reason, Reset::Reason::none);
}

// Nor does it last where one of these is set, unless that is another pass's, or the value that it had.
TEST_F(ChangeGpu, AKeptMemoBeginsAnewOnceWhatItWasMadeWithIsSet) {
    const GpuBuffer read = make_host_buffer(gpu(), 8, VK_BUFFER_USAGE_TRANSFER_DST_BIT, "read");
    View view(program_with(checked(R"("outputs": ["cells", "memo", "value"], "nodes": {
        "keeper": { "type": "keeper" }, "fill": { "type": "toy_fill" } })",
                                   keeper_set(read)),
                           {}),
              {});
    kept_in(view, 0, read);
    EXPECT_TRUE(view.set_param("fill", "scale", 2.0f));
    EXPECT_TRUE(view.set_param("keeper", "seed", 1u));
    EXPECT_EQ(kept_in(view, 1, read), (Kept{1234, 1234}));
    EXPECT_TRUE(view.set_param("keeper", "seed", 2u));
    EXPECT_EQ(kept_in(view, 2, read), (Kept{1234, 0}));
    EXPECT_EQ(view.reset().reason, Reset::Reason::none);
}

// A frame's block has the size of the one before it, whose history it reads, or its own where it reads none.
TEST_F(ChangeGpu, AFrameKnowsTheSizeBefore) {
    NodeSet set;
    NodeEntry looks;
    looks.type = parse_toy(R"({ "node": "looks", "doc": "d", "host": true, "inputs": {},
      "outputs": { "seen": { "kind": "image", "format": "r32f" } } })",
                           "looks");
    std::vector<std::array<uint32_t, 4>> seen;
    looks.callback = [&](const HostPassContext& context) {
        const FrameBlock& f = *context.frame;
        seen.push_back({f.size.v[0], f.size.v[1], f.prev_size.v[0], f.prev_size.v[1]});
    };
    set.add(std::move(looks));
    const CheckedPipeline pipeline =
        checked(R"("outputs": ["seen"], "nodes": { "looks": { "type": "looks" } })", set);
    View view(program_with(pipeline, {}), {});
    const Extent sizes[] = {{20, 10}, {9, 12}, {29, 13}, {7, 7}};
    for (uint32_t f = 0; f < 4; ++f) {
        FrameDescription frame = description(f, sizes[f]);
        frame.prev_size = {1, 1};  // not asked: the view knows
        frame.flags = f == 2 ? uint32_t{frame_reset} : 0u;
        gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, frame, {}); });
    }
    EXPECT_EQ(seen, (std::vector<std::array<uint32_t, 4>>{
                        {20, 10, 20, 10}, {9, 12, 20, 10}, {29, 13, 29, 13}, {7, 7, 29, 13}}));
}

// A frame of a smaller size runs as many groups as it needs, also of a mip chain's levels.
TEST_F(ChangeGpu, DispatchesFollowTheFramesSize) {
    const CheckedPipeline pipeline =
        checked(R"("outputs": ["picked"], "nodes": { "fill": { "type": "toy_fill" },
        "chain": { "type": "toy_chain" }, "pick": { "type": "toy_pick" } })");
    View view(std::make_shared<Program>(Spy::handles(), plan_of(pipeline, {})), {});
    using Groups = std::vector<std::array<uint32_t, 3>>;
    const auto dispatches_of = [&](Extent size) {
        Spy::dispatches.clear();
        gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(0, size), {}); });
        return Spy::dispatches;
    };
    // 8x8 pixels of 29x13, then 4x4 of each level: 29x13 14x6 7x3 3x1 1x1, then 8x8 again.
    EXPECT_EQ(dispatches_of({29, 13}),
              (Groups{{4, 2, 1}, {8, 4, 1}, {4, 2, 1}, {2, 1, 1}, {1, 1, 1}, {1, 1, 1}, {4, 2, 1}}));
    EXPECT_EQ(dispatches_of({9, 8}),
              (Groups{{2, 1, 1}, {3, 2, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {2, 1, 1}}));
}

// Sizes and facts change at random, two frames in flight. A size that the plan is large enough for makes and
// allocates nothing; beyond it, and for other facts, another plan's view takes over. All of them have what
// there was of history; views retire by fences, all memory comes back, and nothing that waits or submits was
// so much as asked for.
TEST_F(ChangeGpu, TwoHundredRandomChangesWithFramesInFlight) {
    const CheckedPipeline pipeline = checked(R"("outputs": ["blended", "level"], "nodes": {
        "fill": { "type": "toy_fill" }, "blend": { "type": "toy_blend", "in": { "history": "blended@-1" } },
        "bright": { "type": "toy_fill", "if": "moves", "params": { "scale": 3 }, "out": { "value": "level" } },
        "dim": { "type": "toy_fill", "if": "!moves", "out": { "value": "level" } } })");
    constexpr Extent small{width, height}, large{width + 16, height + 11};
    const auto fits = [](Extent size, Extent in) {
        return size.width <= in.width && size.height <= in.height;
    };
    Allocator allocator;
    DeviceHandles handles = Spy::handles();
    handles.memory = allocator.callbacks();
    {
        std::map<std::pair<bool, bool>, std::shared_ptr<const Program>> programs;
        for (const bool is_large : {false, true})
            for (const bool moves : {false, true}) {
                const auto plan = program_with(pipeline, {{"moves", moves}}, true, is_large ? large : small);
                programs[{is_large, moves}] =
                    std::make_shared<Program>(handles, std::make_shared<const Plan>(plan->plan()));
            }
        struct InFlight {
            Recorder recorder;
            Owned<VkFence> fence;
            std::vector<std::unique_ptr<View>> retired;  // that the frame here still reads
        } ring[2];
        for (InFlight& slot : ring) {
            VkFenceCreateInfo create{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr,
                                     VK_FENCE_CREATE_SIGNALED_BIT};
            VkFence fence = VK_NULL_HANDLE;
            check(vkCreateFence(gpu().get(), &create, nullptr, &fence), "vkCreateFence", "");
            slot.fence = {gpu().get(), fence};
        }
        const auto wait = [&](const InFlight& slot) {
            const VkFence fence = slot.fence.get();
            check(vkWaitForFences(gpu().get(), 1, &fence, VK_TRUE, ~0ull), "vkWaitForFences", "");
        };
        std::mt19937 random(7);
        size_t most_live = 0;
        Extent size = small;
        bool moves = true, is_large = false;
        uint32_t changes = 0, sizes = 0, larger = 0, smaller = 0, kept_pixels = 0;
        std::unique_ptr<View> view;
        std::vector<float> blended;
        for (uint32_t f = 0; changes < 200; ++f) {
            InFlight& slot = ring[f % 2];
            wait(slot);
            slot.retired.clear();
            const bool change = f > 0 && random() % 2, resize = change && random() % 2;
            const Extent before = size;
            bool another = f == 0;
            if (resize) size = {1 + uint32_t(random() % large.width), 1 + uint32_t(random() % large.height)};
            if (resize && !is_large && !fits(size, small)) another = is_large = true, ++larger;
            if (resize && is_large && fits(size, small) &&
                fits(before, small)) {  // to a plan that takes less memory
                another = true, is_large = false;
                ++smaller;
            }
            if (change && !resize) another = true, moves = !moves;
            changes += change;
            sizes += resize && !another;
            if (another) {
                auto heir = std::make_unique<View>(programs.at({is_large, moves}),
                                                   ViewOptions{.heir_of = view.get()});
                if (view) slot.retired.push_back(std::move(view));
                view = std::move(heir);
            }
            const size_t calls = allocator.calls;
            Spy::made = 0;
            slot.recorder.record([&](VkCommandBuffer cmd) { view->record(cmd, description(f, size), {}); });
            EXPECT_EQ(allocator.calls, calls);
            EXPECT_EQ(Spy::made, 0u);
            EXPECT_EQ(view->reset().reason, f ? Reset::Reason::none : Reset::Reason::first_frame) << f;
            std::vector<float> now(size_t{size.width} * size.height);
            for (uint32_t y = 0; y < size.height; ++y)
                for (uint32_t x = 0; x < size.width; ++x) {
                    const size_t i = size_t{y} * size.width + x;
                    now[i] = static_cast<float>(i + f);
                    if (f == 0 || x >= before.width || y >= before.height) continue;
                    now[i] += 0.5f * blended[size_t{y} * before.width + x];
                    kept_pixels += resize;
                }
            blended = std::move(now);
            VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
            submit.commandBufferCount = 1;
            submit.pCommandBuffers = &slot.recorder.cmd;
            const VkFence fence = slot.fence.get();
            check(vkResetFences(gpu().get(), 1, &fence), "vkResetFences", "");
            check(vkQueueSubmit(gpu().queue(), 1, &submit, fence), "vkQueueSubmit", "");
            most_live = std::max(most_live, allocator.live.size());
            if (f % 7) continue;
            wait(slot);
            const Bytes part = cropped(view->plan(), "blended", view->captured("blended"), size);
            ASSERT_EQ(floats(part), blended) << "frame " << f << ", change " << changes;
        }
        for (const InFlight& slot : ring) wait(slot);
        EXPECT_GT(sizes, 40u);
        EXPECT_GT(larger, 3u);
        EXPECT_GT(smaller, 3u);
        EXPECT_GT(kept_pixels, 1000u);
        EXPECT_LT(most_live, 100u);  // three views and four programs, not two hundred
    }
    EXPECT_TRUE(allocator.live.empty());
    for (const char* name :
         {"vkDeviceWaitIdle", "vkQueueWaitIdle", "vkWaitForFences", "vkQueueSubmit", "vkQueueSubmit2"})
        EXPECT_FALSE(Spy::asked.contains(name)) << name;
}

}  // namespace
}  // namespace penumbra::test
