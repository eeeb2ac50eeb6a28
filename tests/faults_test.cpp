// SPDX-License-Identifier: MIT
// Every Vulkan call that the graph makes fails in turn; every allocation that a compilation makes does. What
// comes of it is an error that names the call and the thing, nothing left alive, and a graph that can be made
// again.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "app/session.h"
#include "penumbra/graph.h"
#include "tests/allocations.h"
#include "tests/faulty_vulkan.h"
#include "tests/gpu_test.h"
#include "tests/plan_mutants.h"
#include "tests/process_size.h"
#include "tests/toy_set.h"

namespace penumbra::test {
namespace {

constexpr Extent extent{29, 13};

std::shared_ptr<const Plan> toy_plan(const DeviceTable& device, bool poison = false) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    CompileOptions options;
    options.captures = pipeline.output_names();
    options.poison = poison;
    Diagnostics diagnostics;
    auto plan = compile(pipeline, {.extent = extent, .device = device}, options, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::make_shared<const Plan>(std::move(*plan));
}

FrameDescription frame_of(uint32_t index) {
    FrameDescription frame;
    frame.camera.clip_from_view = frame.previous.clip_from_view = perspective(1.0, 1.0, 0.1);
    frame.size = frame.prev_size = {extent.width, extent.height};
    frame.index = index;
    return frame;
}

using Outputs = std::vector<std::vector<std::byte>>;

// Everything that a host does with a graph, from its start to its end.
Outputs run(Device& device, const DeviceHandles& handles, const std::shared_ptr<const Plan>& plan,
            uint32_t frames, std::optional<uint32_t> poison = std::nullopt) {
    const auto program = std::make_shared<Program>(handles, plan);
    View view(program, {.frames_in_flight = 1, .poison = poison});
    for (uint32_t f = 0; f < frames; ++f)
        device.run([&](VkCommandBuffer cmd) { view.record(cmd, frame_of(f), {}); });
    static_cast<void>(view.statistics());
    static_cast<void>(program->pipeline_cache());
    Outputs outputs;
    for (const PlanOutput& output : plan->outputs) {
        const auto bytes = view.captured(output.name);
        outputs.emplace_back(bytes.begin(), bytes.end());
    }
    return outputs;
}

class FaultsGpu : public GpuTest {};

TEST_F(FaultsGpu, EveryCallThatFailsIsNamedAndLeavesNothing) {
    const auto plan = toy_plan(device_table(handles_of(gpu())));
    const DeviceHandles handles = FaultyVulkan::handles(handles_of(gpu()));
    const Outputs expected = run(gpu(), handles, plan, 2);
    const size_t calls = FaultyVulkan::calls;
    EXPECT_GT(calls, 100u);
    EXPECT_EQ(FaultyVulkan::objects(), 0);
    std::map<std::string, size_t> failed;
    for (const VkResult failure : {VK_ERROR_OUT_OF_DEVICE_MEMORY, VK_ERROR_DEVICE_LOST, VK_ERROR_UNKNOWN})
        for (size_t n = 1; n <= calls; n += failure == VK_ERROR_OUT_OF_DEVICE_MEMORY ? 1 : 7) {
            FaultyVulkan::reset();
            FaultyVulkan::fail_at = n;
            FaultyVulkan::failure = failure;
            const auto error = attempt([&] { run(gpu(), handles, plan, 2); });
            ASSERT_TRUE(error) << FaultyVulkan::failed << ", call " << n << ", was not missed";
            EXPECT_EQ(error->code, failure == VK_ERROR_DEVICE_LOST ? ErrorCode::device_lost
                                   : failure == VK_ERROR_UNKNOWN   ? ErrorCode::vulkan
                                                                   : ErrorCode::out_of_memory);
            EXPECT_EQ(error->result, failure);
            EXPECT_NE(error->text.find(FaultyVulkan::failed), std::string::npos) << error->text;
            EXPECT_FALSE(error->place.empty()) << FaultyVulkan::failed;
            EXPECT_EQ(FaultyVulkan::objects(), 0) << FaultyVulkan::failed << ", call " << n;
            ++failed[FaultyVulkan::failed];
        }
    EXPECT_EQ(failed.size(), 19u) << "functions that can fail";
    size_t faults = 0;
    for (const auto& [function, count] : failed) faults += count;
    std::printf("%zu faults in %zu calls of %zu functions\n", faults, calls, failed.size());
    FaultyVulkan::reset();
    EXPECT_EQ(run(gpu(), handles, plan, 2), expected) << "afterwards all is as before";
}

// A host that has lost its device makes another one, and the plan is as good there.
TEST_F(FaultsGpu, AfterALostDeviceAnotherDoes) {
    const auto plan = toy_plan(device_table(handles_of(gpu())));
    const Outputs expected = run(gpu(), handles_of(gpu()), plan, 3);
    const auto error = attempt([&] {
        const DeviceHandles handles = FaultyVulkan::handles(handles_of(gpu()));
        FaultyVulkan::failure = VK_ERROR_DEVICE_LOST;
        FaultyVulkan::fail_at = 60;
        run(gpu(), handles, plan, 3);
    });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, ErrorCode::device_lost);
    Device another({gpu().info().name, true});
    EXPECT_EQ(run(another, handles_of(another), plan, 3), expected);
    EXPECT_EQ(another.message_count(), 0u);
}

// What a host reads through mapped memory is made visible to it: no validation layer sees reads of the host.
TEST_F(FaultsGpu, TheLastBarrierIsForWhatTheHostReads) {
    const auto plan = toy_plan(device_table(handles_of(gpu())));
    const DeviceHandles handles = FaultyVulkan::handles(handles_of(gpu()));
    run(gpu(), handles, plan, 1);
    ASSERT_FALSE(FaultyVulkan::barriers.empty());
    const VkMemoryBarrier2& last = FaultyVulkan::barriers.back();
    constexpr VkPipelineStageFlags2 writers =
        VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
    constexpr VkAccessFlags2 writes = VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
    EXPECT_EQ(last.srcStageMask & writers, writers);
    EXPECT_EQ(last.srcAccessMask & writes, writes);
    EXPECT_TRUE(last.dstStageMask & VK_PIPELINE_STAGE_2_HOST_BIT);
    EXPECT_TRUE(last.dstAccessMask & VK_ACCESS_2_HOST_READ_BIT);
}

// PENUMBRA_GRAPHS: how many; docs/reliability.md has a run of ten thousand.
TEST_F(FaultsGpu, ManyGraphsLeaveNothing) {
    const char* wanted = std::getenv("PENUMBRA_GRAPHS");
    const int graphs = wanted ? std::atoi(wanted) : 100;
    Device device({gpu().info().name, false});  // the validation layer keeps some 8 KiB of each
    const auto plan = toy_plan(device_table(handles_of(device)));
    const DeviceHandles handles = FaultyVulkan::handles(handles_of(device));
    for (int i = 0; i < 30; ++i) run(device, handles, plan, 1);  // caches of the driver's fill
    const long resident = resident_kib(), live = live_allocations, files = open_files();
    for (int i = 1; i <= graphs; ++i) {
        run(device, handles, plan, 1);
        if (i % 1000 == 0 || i == graphs)
            std::printf("%d graphs: %ld allocations, %ld KiB resident, %ld open files more\n", i,
                        live_allocations - live, resident_kib() - resident, open_files() - files);
    }
    EXPECT_EQ(open_files(), files);
    EXPECT_EQ(FaultyVulkan::objects(), 0);
    EXPECT_EQ(live_allocations, live) << "by operator new, penumbra's and LLVM's";
    EXPECT_LT(resident_kib() - resident, 8 * 1024 + 2 * graphs);  // Mesa keeps 1.5 KiB of malloc's per graph
}

// Mutants of a plan, run: which of them synchronisation validation reports, and which show in poisoned
// memory. Both are blind to some, all of which the checks of plans see (plan_mutation_test.cpp); none may
// crash.
TEST(FaultsOnADevice, MutantsAreSeenByValidationOrPoison) {
    const char* wish = std::getenv("PENUMBRA_TEST_DEVICE");
    Device device({wish ? wish : "", true});  // its messages are what is looked for
    const DeviceTable table = device_table(handles_of(device));
    std::map<Fault, std::array<size_t, 4>> seen;  // made, by validation; made, by poison
    for (const bool poisoned : {false, true}) {
        const auto plan = toy_plan(table, poisoned);
        const auto poison = poisoned ? std::optional(1u) : std::nullopt;
        const Outputs expected = run(device, handles_of(device), plan, 4, poison);
        if (!poisoned) {
            ASSERT_EQ(device.message_count(), 0u);
        }
        for (const Mutant& mutant : mutants(*plan, table)) {
            const size_t before = device.message_count();
            const Outputs outputs =
                run(device, handles_of(device), std::make_shared<const Plan>(mutant.plan), 4, poison);
            auto& counts = seen[mutant.fault];
            ++counts[poisoned ? 2 : 0];
            counts[poisoned ? 3 : 1] += poisoned ? outputs != expected : device.message_count() != before;
        }
    }
    for (const auto& [fault, counts] : seen)
        std::printf("| %s | %zu of %zu | %zu of %zu |\n", name_of(fault), counts[1], counts[0], counts[3],
                    counts[2]);
    EXPECT_GT(seen[Fault::lifetime_short_packed][3], 0u);
    EXPECT_GT(seen[Fault::activation_dropped][1], 0u);
}

}  // namespace
}  // namespace penumbra::test
