// SPDX-License-Identifier: MIT
// What recording costs a host beside its driver: the functions that record are replaced by ones that do
// nothing. No frame but the first may allocate. And what the standalone host takes for a frame.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <cstring>

#include "app/session.h"
#include "host/models/shapes.h"
#include "penumbra/graph.h"
#include "tests/allocations.h"
#include "tests/c_requests.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"

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
    PENUMBRA_REPLACE(vkCmdCopyBuffer)
    PENUMBRA_REPLACE(vkCmdCopyBufferToImage)
    PENUMBRA_REPLACE(vkCmdCopyImage)
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
        options.share_transients = options.hand_on_history = true;
        const auto made = compile(shipped_pipeline(name),
                                  {.extent = {64, 32},
                                   .facts = {{"alpha", false}, {"translucent", false}},
                                   .device = device_table(handles)},
                                  options, diagnostics);
        ASSERT_TRUE(made) << diagnostics.text();
        const auto plan = std::make_shared<const Plan>(*made);
        const auto program = std::make_shared<const Program>(handles, plan);
        const auto transients = program->make_transients();
        View view(program, {.transients = transients});
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
        View heir(program, {.transients = transients, .heir_of = &view});
        frame.flags = 0;
        const size_t of_heir = allocations;
        heir.record(cmd, frame, externals);
        EXPECT_EQ(allocations, of_heir) << name << ", an heir's first frame";
        EXPECT_EQ(heir.reset().reason, Reset::Reason::none);
        std::printf("%s: %.0f ns per pass, %zu passes\n", name,
                    ns / frames / static_cast<double>(plan->passes.size()), plan->passes.size());
    }
}

size_t allocations_of(const std::function<void()>& act) {
    const size_t before = allocations;
    act();
    return allocations - before;
}

// Shadow maps are fitted to the box of all triangles, for which the tree is posed: nobody does it for a
// pipeline without them, neither for each of the shot's frames when it is opened nor in a frame.
TEST_F(SteadyStateGpu, APipelineWithoutShadowMapsHasNoneFitted) {
    SessionOptions options;
    options.size = {64, 32};
    const auto open = [&](uint32_t frames) {
        return open_session(shipped_pipeline("raw"), plaza_shot(options.size, frames), options);
    };
    const auto session = open(4);  // with all that is made once
    constexpr uint32_t many = 10'000;
    EXPECT_LT(allocations_of([&] { open(many); }), allocations_of([&] { open(1); }) + many);
    EXPECT_EQ(allocations_of([&] { session->host().frame(3, false); }), 0u);
}

// However many parts deform.
TEST(SceneBoxes, TakeOnePoseOfTheTree) {
    constexpr size_t parts = 8;
    Part part = to_part(ground(1, 1, 1, 1), -1);
    part.targets = {std::vector<glm::vec3>(part.positions.size(), {0, 1, 0})};
    Model model;
    model.meshes.emplace_back().parts.assign(parts, part);
    Node& node = model.nodes.emplace_back();
    node.name = "sheets";
    node.mesh = 0;
    node.weights = {1};
    Shot shot;
    shot.objects["sheets"].keys = {{.frame = 0}, {.frame = 10, .translation = {1, 0, 0}}};
    const Scene scene(model, shot);
    const size_t of_part = allocations_of([&] { scene.positions(scene.instances()[0], part, 3); }),
                 of_transforms = allocations_of([&] { scene.transforms(3); });
    EXPECT_LT(allocations_of([&] { scene.box(3); }), of_transforms + parts * of_part);
    EXPECT_LT(allocations_of([&] { scene.moved_boxes(3, 7); }), 2 * (of_transforms + parts * of_part));
}

// Through penumbra.h each frame brings its externals anew.
TEST_F(SteadyStateGpu, RecordingFromCAllocatesNothing) {
    penumbra_device device = c_device();
    device.get_instance_proc_addr = of_instance;
    penumbra_fact facts[] = {{sizeof facts[0], VK_FALSE, "alpha"},
                             {sizeof facts[0], VK_FALSE, "translucent"}};
    penumbra_plan_request request = request_of(nullptr);
    request.file = PENUMBRA_SOURCE_DIR "/pipelines/shadows.json";
    request.device = &device;
    request.facts = facts;
    request.fact_count = 2;
    penumbra_error error = sized<penumbra_error>();
    penumbra_plan* plan = nullptr;
    ASSERT_EQ(penumbra_plan_create(&request, &plan, &error), PENUMBRA_OK) << error.text;
    penumbra_program* program = nullptr;
    ASSERT_EQ(penumbra_program_create(&device, plan, nullptr, &program, &error), PENUMBRA_OK) << error.text;
    penumbra_view* view = nullptr;
    ASSERT_EQ(penumbra_view_create(program, nullptr, &view, &error), PENUMBRA_OK) << error.text;
    penumbra_handover handover = sized<penumbra_handover>();
    handover.image = reinterpret_cast<VkImage>(1);
    handover.layout_before = VK_IMAGE_LAYOUT_GENERAL;
    handover.family_before = handover.family_after = VK_QUEUE_FAMILY_IGNORED;
    std::vector<penumbra_external> externals(penumbra_plan_slot_count(plan), sized<penumbra_external>());
    for (uint32_t i = 0; i < externals.size(); ++i) {  // never looked at
        penumbra_slot slot = sized<penumbra_slot>();
        ASSERT_EQ(penumbra_plan_slot(plan, i, &slot, &error), PENUMBRA_OK);
        externals[i].name = slot.name;
        externals[i].image = reinterpret_cast<VkImageView>(1);
        externals[i].texels = reinterpret_cast<VkBufferView>(1);
        externals[i].buffer = reinterpret_cast<VkBuffer>(1);
        if (slot.kind == PENUMBRA_IMAGE) externals[i].handover = &handover;
    }
    penumbra_frame frame = sized<penumbra_frame>();
    frame.size[0] = request.width;
    frame.size[1] = request.height;
    look(frame);
    const auto record = [&] {
        return penumbra_view_record(view, reinterpret_cast<VkCommandBuffer>(1), &frame, externals.data(),
                                    uint32_t(externals.size()), &error);
    };
    ASSERT_EQ(record(), PENUMBRA_OK) << error.place << ": " << error.text;
    const size_t before = allocations;
    penumbra_code code = PENUMBRA_OK;
    for (uint32_t f = 0; f < 10 && code == PENUMBRA_OK; ++f) code = record();
    EXPECT_EQ(allocations, before);
    EXPECT_EQ(code, PENUMBRA_OK) << error.place << ": " << error.text;
    penumbra_view_destroy(view);
    penumbra_program_destroy(program);
    penumbra_plan_destroy(plan);
}

}  // namespace
}  // namespace penumbra::test
