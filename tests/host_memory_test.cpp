// SPDX-License-Identifier: MIT
// Memory from the host: all of it, all of it given back, what it is for, and what is said where it fails; and
// where it comes from without a host.
#include "graph/memory_type.h"
#include "tests/embedding_host.h"

namespace penumbra::test {
namespace {

class HostMemoryGpu : public GpuTest {};

TEST_F(HostMemoryGpu, MemoryComesFromTheHost) {
    Allocator allocator;
    const Outputs expected = run_toys(handles_of(gpu()), 3);
    DeviceHandles handles = Spy::handles();
    handles.memory = allocator.callbacks();
    Spy::bound.clear();
    EXPECT_EQ(run_toys(handles, 3), expected);
    EXPECT_GT(allocator.calls, 3u);
    EXPECT_TRUE(allocator.live.empty());
    // Nothing lies in front of its block, where others of the host's are, and images lie in blocks that were
    // asked for as such.
    EXPECT_GT(Spy::bound.size(), allocator.calls);
    for (const Spy::Bound& bound : Spy::bound) {
        EXPECT_GE(bound.offset, allocator.blocks.at(bound.memory).offset);
        EXPECT_EQ(bound.image, !allocator.blocks.at(bound.memory).linear);
    }
}

TEST_F(HostMemoryGpu, WhatIsAllocatedIsWhatIsSaid) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    Allocator allocator;
    DeviceHandles handles = handles_of(gpu());
    handles.memory = allocator.callbacks();
    const auto asked_for = [&](auto&& make) {
        const uint64_t before = allocator.bytes;
        const auto made = make();
        return std::pair(allocator.bytes - before, made);
    };
    const auto [of_program, program] = asked_for(
        [&] { return std::make_shared<Program>(handles, plan_of(pipeline, capturing(pipeline, true))); });
    EXPECT_EQ(of_program, program->bytes());
    const auto [shared, transients] = asked_for([&, p = program] { return p->make_transients(); });
    EXPECT_EQ(shared, bytes_of(*transients));
    for (const uint32_t n : {1u, 3u}) {
        const auto [own, view] = asked_for([&, p = program, shared_memory = transients] {
            return std::make_shared<View>(p, ViewOptions{.frames_in_flight = n, .transients = shared_memory});
        });
        EXPECT_EQ(own, view->bytes()) << n;
    }
}

TEST_F(HostMemoryGpu, WhatTheHostReadsIsAskedForAsSuch) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    Allocator allocator;
    const HostMemory good = allocator.callbacks();
    std::set<std::string> reads, others;
    DeviceHandles handles = handles_of(gpu());
    handles.memory = {[&](const MemoryRequest& request, MemoryBlock& block) {
                          (request.readback ? reads : others).insert(request.what);
                          return good.allocate(request, block);
                      },
                      good.release};
    {
        const View view(std::make_shared<Program>(handles, plan_of(pipeline, capturing(pipeline))), {});
        std::set<std::string> expected{"counters"};
        for (const PlanPass& pass : view.plan().passes)
            if (pass.kind == PassKind::capture) expected.insert("a capture of " + pass.node);
        EXPECT_GT(expected.size(), 1u);
        EXPECT_EQ(reads, expected);
        EXPECT_TRUE(others.contains("the frame block"));
    }
    EXPECT_TRUE(allocator.live.empty());
}

// A card with 8 GiB, in a machine with 32: memory that its processor writes in bursts comes before memory
// that it caches, of which a part needs flushing.
VKAPI_ATTR void VKAPI_CALL card_memory(VkPhysicalDevice, VkPhysicalDeviceMemoryProperties* memory) {
    constexpr VkMemoryPropertyFlags visible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT,
                                    coherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                                    cached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    *memory = {.memoryTypeCount = 4,
               .memoryTypes = {{VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0},
                               {visible | coherent, 1},
                               {visible | cached, 1},
                               {visible | coherent | cached, 1}},
               .memoryHeapCount = 2,
               .memoryHeaps = {{VkDeviceSize{8} << 30, VK_MEMORY_HEAP_DEVICE_LOCAL_BIT},
                               {VkDeviceSize{32} << 30, 0}}};
}

TEST_F(HostMemoryGpu, WhatTheHostReadsIsCachedWhereThatIsCoherent) {
    VkPhysicalDeviceMemoryProperties card;
    card_memory(VK_NULL_HANDLE, &card);
    constexpr VkMemoryPropertyFlags mapped =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    EXPECT_EQ(memory_type(card, 0b1111, mapped, true), 3u);
    EXPECT_EQ(memory_type(card, 0b1111, mapped, false), 1u);
    EXPECT_EQ(memory_type(card, 0b0111, mapped, true), 1u) << "not the one that needs flushing";
    EXPECT_FALSE(memory_type(card, 0b0001, mapped, true));
}

TEST_F(HostMemoryGpu, ADevicesMemoryIsItsOwn) {
    DeviceHandles handles = handles_of(gpu());
    handles.get_instance_proc_addr = +[](VkInstance instance, const char* name) -> PFN_vkVoidFunction {
        if (std::strcmp(name, "vkGetPhysicalDeviceMemoryProperties"))
            return vkGetInstanceProcAddr(instance, name);
        return reinterpret_cast<PFN_vkVoidFunction>(card_memory);
    };
    EXPECT_EQ(device_table(handles).memory_bytes, uint64_t{8} << 30);
}

// For every call that the allocator may fail: an error that says so, nothing left behind, and then it works.
TEST_F(HostMemoryGpu, AnAllocatorThatFailsLeavesNothingBehind) {
    Allocator allocator;
    DeviceHandles handles = handles_of(gpu());
    handles.memory = allocator.callbacks();
    run_toys(handles, 1);
    const size_t calls = allocator.calls;
    for (size_t n = 1; n <= calls; ++n) {
        allocator.calls = 0;
        allocator.fail_at = n;
        allocator.failure = n % 2 ? VK_ERROR_OUT_OF_DEVICE_MEMORY : VK_ERROR_FRAGMENTED_POOL;
        const auto error = attempt([&] { run_toys(handles, 1); });
        ASSERT_TRUE(error) << n;
        EXPECT_EQ(error->code, ErrorCode::out_of_memory) << n;
        EXPECT_EQ(error->result, allocator.failure) << n;
        EXPECT_FALSE(error->place.empty()) << n;
        EXPECT_EQ(allocator.calls, n);
        EXPECT_TRUE(allocator.live.empty()) << n;
    }
    allocator.calls = 0;
    allocator.fail_at = ~size_t{0};
    EXPECT_FALSE(attempt([&] { run_toys(handles, 1); }));
    EXPECT_TRUE(allocator.live.empty());
}

TEST_F(HostMemoryGpu, AnAllocatorThatBreaksItsWordIsTheHostsMistake) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    const auto plan = plan_of(pipeline, {});
    const auto error_of = [&](auto&& spoil) {
        Allocator allocator;
        DeviceHandles handles = handles_of(gpu());
        const HostMemory good = allocator.callbacks();
        handles.memory = {[&](const MemoryRequest& request, MemoryBlock& block) {
                              const VkResult result = good.allocate(request, block);
                              spoil(block);
                              return result;
                          },
                          [&](const MemoryBlock& block) {
                              MemoryBlock whole = block;
                              whole.memory = static_cast<VkDeviceMemory>(block.user);
                              good.release(whole);
                          }};
        const auto error = attempt([&] { View view(std::make_shared<Program>(handles, plan), {}); });
        EXPECT_TRUE(allocator.live.empty());
        EXPECT_TRUE(error && error->code == ErrorCode::usage);
        return error ? error->text : "";
    };
    EXPECT_NE(error_of([](MemoryBlock& b) { b.memory = VK_NULL_HANDLE; }).find("no memory"),
              std::string::npos);
    EXPECT_NE(error_of([](MemoryBlock& b) { b.offset += 1; }).find("not aligned"), std::string::npos);
    EXPECT_NE(error_of([](MemoryBlock& b) { b.mapped = nullptr; }).find("not mapped"), std::string::npos);
}

}  // namespace
}  // namespace penumbra::test
