// SPDX-License-Identifier: MIT
// What recording costs a host beside its driver: the functions that record are replaced by ones that do
// nothing. No frame but the first may allocate.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <cstring>

#include "app/session.h"
#include "graph/functions.h"
#include "penumbra/graph.h"
#include "tests/allocations.h"
#include "tests/gpu_test.h"
#include "tests/process_size.h"
#include "tests/shipped.h"
#include "tests/toy_set.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

size_t calls = 0;

template <class F>
struct Nothing;
template <class... Arguments>
struct Nothing<void(VKAPI_PTR*)(Arguments...)> {
    static void VKAPI_CALL call(Arguments...) { ++calls; }
};
template <class... Arguments>
struct Nothing<VkResult(VKAPI_PTR*)(Arguments...)> {
    static VkResult VKAPI_CALL call(Arguments...) { return ++calls, VK_NOT_READY; }
};

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_device(VkDevice device, const char* name) {
#define PENUMBRA_REPLACE(function)     \
    if (!std::strcmp(name, #function)) \
        return reinterpret_cast<PFN_vkVoidFunction>(Nothing<PFN_##function>::call);
    PENUMBRA_REPLACE(vkCmdBeginDebugUtilsLabelEXT)
    PENUMBRA_REPLACE(vkCmdBindDescriptorSets)
    PENUMBRA_REPLACE(vkCmdBindPipeline)
    PENUMBRA_REPLACE(vkCmdClearColorImage)
    PENUMBRA_REPLACE(vkCmdCopyBufferToImage)
    PENUMBRA_REPLACE(vkCmdCopyImageToBuffer)
    PENUMBRA_REPLACE(vkCmdDispatch)
    PENUMBRA_REPLACE(vkCmdDispatchIndirect)
    PENUMBRA_REPLACE(vkCmdEndDebugUtilsLabelEXT)
    PENUMBRA_REPLACE(vkCmdFillBuffer)
    PENUMBRA_REPLACE(vkCmdPipelineBarrier2)
    PENUMBRA_REPLACE(vkCmdPushConstants)
    PENUMBRA_REPLACE(vkCmdResetQueryPool)
    PENUMBRA_REPLACE(vkCmdWriteTimestamp2)
    PENUMBRA_REPLACE(vkGetQueryPoolResults)
    PENUMBRA_REPLACE(vkUpdateDescriptorSets)
#undef PENUMBRA_REPLACE
    return vkGetDeviceProcAddr(device, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_instance(VkInstance instance, const char* name) {
    if (!std::strcmp(name, "vkGetDeviceProcAddr")) return reinterpret_cast<PFN_vkVoidFunction>(of_device);
    return vkGetInstanceProcAddr(instance, name);
}

class SteadyStateGpu : public GpuTest {};

TEST_F(SteadyStateGpu, RecordingAllocatesNothing) {
    size_t counting = allocations;
    delete new int;
    ASSERT_EQ(allocations, counting + 1) << "nothing is counted";
    for (const char* name : {"shadows", "hybrid_shadows", "fidelityfx"}) {
        DeviceHandles handles = handles_of(gpu());
        handles.get_instance_proc_addr = of_instance;
        Diagnostics diagnostics;
        CompileOptions options;
        options.share_transients = true;
        const auto made = compile(shipped_pipeline(name),
                                  {.extent = {64, 32},
                                   .facts = {{"alpha", false}, {"translucent", false}},
                                   .device = device_table(handles)},
                                  options, diagnostics);
        ASSERT_TRUE(made) << diagnostics.text();
        const auto plan = std::make_shared<const Plan>(*made);
        const auto program = std::make_shared<const Program>(handles, plan);
        View view(program, {.transients = program->make_transients()});
        Externals externals(*plan);
        for (const HostSlot& slot : plan->slots) {  // never looked at
            SlotBinding& binding = externals[slot.name];
            binding.image = reinterpret_cast<VkImageView>(1);
            binding.texels = reinterpret_cast<VkBufferView>(1);
            binding.buffer = reinterpret_cast<VkBuffer>(1);
            if (slot.kind == PortKind::image)
                binding.handover =
                    Handover{.image = reinterpret_cast<VkImage>(1), .layout_before = VK_IMAGE_LAYOUT_GENERAL};
        }
        FrameDescription frame;
        frame.size = frame.prev_size = {64, 32};
        frame.camera.clip_from_view = frame.previous.clip_from_view = perspective(1.0, 2.0, 0.1);
        const auto cmd = reinterpret_cast<VkCommandBuffer>(1);
        view.record(cmd, frame, externals);
        constexpr uint32_t frames = 1000;
        const size_t before = allocations, calls_before = calls;
        const auto start = std::chrono::steady_clock::now();
        for (uint32_t f = 0; f < frames; ++f) {
            frame.flags = f % 10 == 9 ? uint32_t{frame_reset} : 0u;
            view.record(cmd, frame, externals);
        }
        const double ns =
            std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
        EXPECT_EQ(allocations, before) << name;
        EXPECT_GT(calls - calls_before, frames * plan->passes.size()) << name;
        std::printf("%s: %.0f ns per pass, %zu passes\n", name,
                    ns / frames / static_cast<double>(plan->passes.size()), plan->passes.size());
    }
}

}  // namespace
}  // namespace penumbra::test
