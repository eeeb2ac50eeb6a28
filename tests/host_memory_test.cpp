// SPDX-License-Identifier: MIT
// Memory from the host: all of it, all of it given back, and what is said where it fails.
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
