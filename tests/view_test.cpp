// SPDX-License-Identifier: MIT
// A view's promises to its host: frames that overlap in flight, history of host images through the built-in
// copy, resets in mid-stream, callbacks of host nodes, and errors for what the host forgets.
#include "penumbra/view.h"

#include <algorithm>
#include <cstring>

#include "app/session.h"
#include "host/device/gpu.h"
#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"
#include "tests/embedding_host.h"
#include "tests/toy_nodes.h"

namespace penumbra::test {
namespace {

std::shared_ptr<Program> program_of(const CheckedPipeline& pipeline, bool poison = false) {
    Target target;
    target.extent = {width, height};
    target.device = device_table(handles_of(gpu()));
    CompileOptions options;
    options.captures = pipeline.output_names();
    options.poison = poison;
    Diagnostics diagnostics;
    auto plan = compile(pipeline, target, options, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::make_shared<Program>(handles_of(gpu()), std::make_shared<Plan>(std::move(*plan)));
}

FrameDescription frame_at(uint32_t index, bool reset = false) {
    FrameDescription frame;
    frame.camera.clip_from_view = frame.previous.clip_from_view = perspective(1.0, 1.0, 0.1);
    frame.size = frame.prev_size = {width, height};
    frame.index = index;
    if (reset) frame.flags = frame_reset;
    return frame;
}

// n command buffers and fences in a ring: frame f is recorded as soon as frame f - n has completed.
class Ring {
  public:
    explicit Ring(uint32_t n) : slots_(n) {
        const VkDevice device = gpu().get();
        for (Slot& slot : slots_) {
            VkCommandPoolCreateInfo create{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
            create.queueFamilyIndex = gpu().queue_family();
            VkCommandPool pool = VK_NULL_HANDLE;
            check(vkCreateCommandPool(device, &create, nullptr, &pool), "vkCreateCommandPool", "ring");
            slot.pool = {device, pool};
            VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
            allocate.commandPool = pool;
            allocate.commandBufferCount = 1;
            check(vkAllocateCommandBuffers(device, &allocate, &slot.cmd), "vkAllocateCommandBuffers", "ring");
            VkFenceCreateInfo fence_create{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
            fence_create.flags = VK_FENCE_CREATE_SIGNALED_BIT;
            VkFence fence = VK_NULL_HANDLE;
            check(vkCreateFence(device, &fence_create, nullptr, &fence), "vkCreateFence", "ring");
            slot.fence = {device, fence};
        }
    }
    ~Ring() { vkQueueWaitIdle(gpu().queue()); }

    template <class Record>
    void submit(uint32_t frame, Record&& record) {
        Slot& slot = slots_[frame % slots_.size()];
        const VkDevice device = gpu().get();
        const VkFence fence = slot.fence.get();
        check(vkWaitForFences(device, 1, &fence, VK_TRUE, ~0ull), "vkWaitForFences", "ring");
        check(vkResetFences(device, 1, &fence), "vkResetFences", "ring");
        check(vkResetCommandPool(device, slot.pool.get(), 0), "vkResetCommandPool", "ring");
        VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
        check(vkBeginCommandBuffer(slot.cmd, &begin), "vkBeginCommandBuffer", "ring");
        record(slot.cmd);
        check(vkEndCommandBuffer(slot.cmd), "vkEndCommandBuffer", "ring");
        VkSubmitInfo info{VK_STRUCTURE_TYPE_SUBMIT_INFO};
        info.commandBufferCount = 1;
        info.pCommandBuffers = &slot.cmd;
        check(vkQueueSubmit(gpu().queue(), 1, &info, fence), "vkQueueSubmit", "ring");
    }
    static void wait() { check(vkQueueWaitIdle(gpu().queue()), "vkQueueWaitIdle", "ring"); }

  private:
    struct Slot {
        Owned<VkCommandPool> pool;
        VkCommandBuffer cmd = VK_NULL_HANDLE;
        Owned<VkFence> fence;
    };
    std::vector<Slot> slots_;
};

class ViewGpu : public GpuTest {};

// Each burst is submitted without waiting for anything but the ring; every output and counter of its last
// frame must be what the same frames give one at a time.
TEST_F(ViewGpu, OverlappingFramesGiveWhatFramesOneAtATimeGive) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    const auto program = program_of(pipeline);
    View alone(program, {.frames_in_flight = 1});
    std::vector<std::map<std::string, std::vector<float>>> expected(9);
    for (uint32_t f = 0; f < expected.size(); ++f) {
        gpu().run([&](VkCommandBuffer cmd) { alone.record(cmd, frame_at(f, f == 5), {}); });
        for (const std::string& name : pipeline.output_names())
            expected[f][name] = floats(alone.captured(name));
    }
    for (const uint32_t n : {1u, 2u, 3u})
        for (const uint32_t last : {2u, 5u, 8u}) {
            View view(program, {.frames_in_flight = n});
            Ring ring(n);
            for (uint32_t f = 0; f <= last; ++f)
                ring.submit(f, [&](VkCommandBuffer cmd) { view.record(cmd, frame_at(f, f == 5), {}); });
            Ring::wait();
            for (const std::string& name : pipeline.output_names())
                EXPECT_EQ(floats(view.captured(name)), expected[last][name])
                    << name << " " << n << " in flight, " << last;
            const auto statistics = view.statistics();
            for (size_t p = 0; p < statistics.size(); ++p) {
                if (view.plan().passes[p].node != "fill") continue;
                EXPECT_EQ(statistics[p].counters, std::vector<uint32_t>{width * height}) << n << " in flight";
            }
        }
}

// What a pass leaves unwritten stays as it was, among neighbours that share memory and are poisoned; a reset
// empties it.
TEST_F(ViewGpu, WhatIsKeptLastsUntilAReset) {
    const CheckedPipeline pipeline = checked(R"("outputs": ["tally", "trail", "blended"], "nodes": {
        "tally": { "type": "toy_tally" }, "fill": { "type": "toy_fill" },
        "blend": { "type": "toy_blend", "in": { "history": "blended@-1" } } })",
                                             toy_set());
    const auto program = program_of(pipeline, true);
    for (const uint32_t n : {1u, 3u})
        for (const uint32_t last : {0u, 3u, 4u, 7u}) {
            View view(program, {.frames_in_flight = n, .poison = last & 1});
            Ring ring(n);
            for (uint32_t f = 0; f <= last; ++f)
                ring.submit(f, [&](VkCommandBuffer cmd) { view.record(cmd, frame_at(f, f == 4), {}); });
            Ring::wait();
            const uint32_t first = last < 4 ? 0 : 4;
            uint32_t tally[2] = {};
            std::memcpy(tally, view.captured("tally").data(), sizeof tally);
            EXPECT_EQ(tally[0], last - first + 1);
            EXPECT_EQ(tally[1], last);
            std::vector<float> expected(width * height, 0.0f);
            for (uint32_t f = first; f <= last; ++f) expected[f] = static_cast<float>(f + 1);
            EXPECT_EQ(floats(view.captured("trail")), expected) << n << " in flight, frame " << last;
        }
}

const char* const given_input =
    R"("inputs": { "given": { "format": "r32f" } }, "outputs": ["blended"],
    "nodes": { "blend": { "type": "toy_blend", "in": { "value": "given" } } })";

// A host image of one value per frame, one image for each frame in flight.
struct Given {
    explicit Given(uint32_t n) {
        for (uint32_t i = 0; i < n; ++i)
            images.push_back(make_image(gpu(), VK_FORMAT_R32_SFLOAT, {width, height}, 1,
                                        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                                        "given"));
    }
    SlotBinding bind(uint32_t frame) const {
        return {.image = images[frame % images.size()].view.get(), .layout = VK_IMAGE_LAYOUT_GENERAL};
    }
    void fill(VkCommandBuffer cmd, uint32_t frame, float value) const {
        constexpr VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
        barrier.image = images[frame % images.size()].get();
        barrier.subresourceRange = all;
        barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
        barrier.srcStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
        barrier.dstStageMask = VK_PIPELINE_STAGE_2_CLEAR_BIT;
        barrier.dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
        VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
        dependency.imageMemoryBarrierCount = 1;
        dependency.pImageMemoryBarriers = &barrier;
        vkCmdPipelineBarrier2(cmd, &dependency);
        VkClearColorValue colour{};
        colour.float32[0] = value;
        vkCmdClearColorImage(cmd, barrier.image, VK_IMAGE_LAYOUT_GENERAL, &colour, 1, &all);
        barrier.oldLayout = VK_IMAGE_LAYOUT_GENERAL;
        barrier.srcStageMask = VK_PIPELINE_STAGE_2_CLEAR_BIT;
        barrier.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
        barrier.dstStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
        barrier.dstAccessMask = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
        vkCmdPipelineBarrier2(cmd, &dependency);
    }
    std::vector<GpuImage> images;
};

TEST_F(ViewGpu, ASlotThatIsNotBoundIsNamed) {
    View view(program_of(checked(given_input, toy_set())), {});
    const SlotBinding nothing;
    const auto message = [&](std::span<const SlotBinding> slots) -> std::string {
        std::string text;
        gpu().run([&](VkCommandBuffer cmd) {
            try {
                view.record(cmd, frame_at(0), slots);
            } catch (const Failure& e) {
                text = e.what();
            }
        });
        return text;
    };
    EXPECT_NE(message({&nothing, 1}).find("\"given\""), std::string::npos);
    EXPECT_NE(message({}).find("0 slots were bound, the plan has 1"), std::string::npos);
}

// A new view of another image may have the handle of a destroyed one; the frame must read the new image.
TEST_F(ViewGpu, AHandleMayComeBackForAnotherImage) {
    View view(program_of(checked(given_input, toy_set())), {.frames_in_flight = 1});
    for (uint32_t f = 0; f < 4; ++f) {
        const Given given(1);
        const SlotBinding slot = given.bind(f);
        gpu().run([&](VkCommandBuffer cmd) {
            given.fill(cmd, f, static_cast<float>(f + 1));
            view.record(cmd, frame_at(f, true), {&slot, 1});
        });
        EXPECT_EQ(floats(view.captured("blended"))[0], static_cast<float>(f + 1));
    }
}

// A callback that copies with transfer commands between two compute passes.
NodeSet set_with_engine(HostCallback callback) {
    NodeSet set;
    for (const std::string& name : toy_set().names()) set.add(*toy_set().find(name));
    NodeEntry engine;
    engine.type = parse_toy(R"({ "node": "engine", "doc": "d", "host": true,
      "inputs": { "value": { "kind": "image", "format": "r32f" } },
      "outputs": { "drawn": { "kind": "image", "format": "r32f" } } })",
                            "engine");
    engine.callback = std::move(callback);
    set.add(std::move(engine));
    return set;
}

const char* const engine_pipeline = R"("outputs": ["blended", "drawn"], "nodes": {
    "fill": { "type": "toy_fill" }, "engine": { "type": "engine" },
    "blend": { "type": "toy_blend", "in": { "value": "drawn", "history": "blended@-1" } } })";

TEST_F(ViewGpu, AHostNodesCallbackRecordsBetweenItsNeighbours) {
    uint32_t calls = 0;
    const NodeSet set = set_with_engine([&](const HostPassContext& context) {
        ++calls;
        EXPECT_EQ(context.pass->node, "engine");
        EXPECT_EQ(context.resource("nosuch"), nullptr);
        EXPECT_EQ(context.frame->frame_index, calls - 1);
        VkImageCopy copy{};
        copy.srcSubresource = copy.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.extent = {width, height, 1};
        vkCmdCopyImage(context.cmd, context.resource("value")->image, VK_IMAGE_LAYOUT_GENERAL,
                       context.resource("drawn")->image, VK_IMAGE_LAYOUT_GENERAL, 1, &copy);
    });
    View view(program_of(checked(engine_pipeline, set), true), {.frames_in_flight = 2, .poison = 0});
    std::vector<float> blended(width * height, 0.0f);
    for (uint32_t f = 0; f < 4; ++f) {
        gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, frame_at(f), {}); });
        std::vector<float> drawn(width * height);
        for (uint32_t i = 0; i < drawn.size(); ++i) {
            drawn[i] = static_cast<float>(i + f);
            blended[i] = drawn[i] + 0.5f * blended[i];
        }
        EXPECT_EQ(floats(view.captured("drawn")), drawn) << f;
        EXPECT_EQ(floats(view.captured("blended")), blended) << f;
    }
    EXPECT_EQ(calls, 4u);
}

TEST_F(ViewGpu, AHostNodeWithoutACallbackIsAnErrorBeforeTheFirstFrame) {
    const NodeSet set = set_with_engine({});
    const CheckedPipeline pipeline = checked(engine_pipeline, set);
    EXPECT_THROW(program_of(pipeline), Failure);
}

TEST_F(ViewGpu, AParameterKeepsItsValueWhereANewOneDoesNotFit) {
    const NodeSet& set = toy_set();
    View view(
        program_of(checked(R"("outputs": ["value"], "nodes": { "fill": { "type": "toy_fill" } })", set)), {});
    EXPECT_FALSE(view.set_param("fill", "scale", ParamValue(int32_t{3})));
    EXPECT_FALSE(view.set_param("fill", "scale", ParamValue(std::vector<float>(1000, 3.0f))));
    EXPECT_FALSE(view.set_param("fill", "nosuch", ParamValue(3.0f)));
    const size_t passes = view.plan().passes.size(), params = view.plan().passes[0].params.size();
    EXPECT_FALSE(view.set_param(passes, 0, ParamValue(3.0f)));
    EXPECT_FALSE(view.set_param(0, params, ParamValue(3.0f)));
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, frame_at(0), {}); });
    EXPECT_EQ(floats(view.captured("value"))[10], 10.0f);
}

}  // namespace
}  // namespace penumbra::test
