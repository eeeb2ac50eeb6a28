// SPDX-License-Identifier: MIT
// What a host may ask, and what it is told where it is wrong.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>
#include <set>

#include "app/pipeline_file.h"
#include "penumbra/shadow_nodes.h"
#include "penumbra/user_nodes.h"
#include "tests/embedding_host.h"
#include "tests/shipped.h"
#include "tests/test_folder.h"
#include "tests/toy_nodes.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

class HostAsksGpu : public GpuTest {};

// Three frames in flight: when frame f is recorded, the counters of frame f - 3 are there, and nobody waited.
TEST_F(HostAsksGpu, StatisticsOfCompletedFramesCostNoWaiting) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    const auto program = std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline)));
    for (const bool timestamps : {true, false}) {
        View view(program, {.frames_in_flight = 3, .timestamps = timestamps});
        for (uint32_t f = 0; f < 6; ++f) {
            gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(f), {}); });
            const FrameStatistics* completed = view.completed();
            ASSERT_EQ(completed != nullptr, f >= 3) << f;
            if (!completed) continue;
            EXPECT_EQ(completed->frame, f - 3);
            for (size_t p = 0; p < completed->passes.size(); ++p) {
                EXPECT_EQ(completed->passes[p].ms.has_value(), timestamps && gpu().caps().timestamps);
                if (view.plan().passes[p].node == "fill") {
                    EXPECT_EQ(completed->passes[p].counters, std::vector<uint32_t>{width * height});
                }
            }
        }
    }
}

// Lavapipe keeps nothing in a cache but its header, which says whose it is: what goes in and out is what
// counts.
TEST_F(HostAsksGpu, APipelineCacheGoesOutAndComesIn) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    const auto plan = plan_of(pipeline, {});
    const std::vector<std::byte> cache = Program(Spy::handles(), plan).pipeline_cache();
    EXPECT_TRUE(Spy::cache.empty());
    VkPipelineCacheHeaderVersionOne header{};
    ASSERT_GE(cache.size(), sizeof header);
    std::memcpy(&header, cache.data(), sizeof header);
    EXPECT_EQ(header.headerVersion, VK_PIPELINE_CACHE_HEADER_VERSION_ONE);
    const Program again(Spy::handles(), plan, {.pipeline_cache = cache});
    EXPECT_EQ(Spy::cache, cache);
    const std::vector<std::byte> rubbish(100, std::byte{7});
    EXPECT_NO_THROW(Program(handles_of(gpu()), plan, {.pipeline_cache = rubbish}));
}

const Requirement* need_of(const std::vector<Requirement>& list, const std::string& name) {
    const auto found = std::ranges::find(list, name, &Requirement::name);
    return found == list.end() ? nullptr : &*found;
}

TEST_F(HostAsksGpu, RequirementsSayWhatAndWhy) {
    const CheckedPipeline pipeline = shipped_pipeline("shadows");
    Diagnostics diagnostics;
    Target target{.extent = {1280, 720}, .device = reference_device()};
    const auto plan = compile(pipeline, target, {}, diagnostics);
    ASSERT_TRUE(plan) << diagnostics.text();
    const std::vector<Requirement> needs = requirements(*plan);
    EXPECT_EQ(need_of(needs, "Vulkan")->value, VK_API_VERSION_1_3);
    ASSERT_TRUE(need_of(needs, "maxImageDimension2D"));
    EXPECT_EQ(need_of(needs, "maxImageDimension2D")->value, 1280u);
    ASSERT_TRUE(need_of(needs, "shaderStorageImageExtendedFormats"));
    EXPECT_NE(need_of(needs, "supportedOperations"), nullptr);
    EXPECT_EQ(need_of(needs, "VK_KHR_ray_query"), nullptr);  // it traces with penumbra's tree
    for (const Requirement& r : needs) {
        EXPECT_FALSE(r.why.empty()) << r.name;
        EXPECT_EQ(r.name.find("SPIR-V"), std::string::npos) << r.name << " for " << r.why;
    }
    EXPECT_TRUE(unmet(*plan, handles_of(gpu())).empty());

    target.device.features = {"ray_query"};
    const auto queries = compile(pipeline, target, {}, diagnostics);
    ASSERT_TRUE(queries) << diagnostics.text();
    const auto query = requirements(*queries);
    ASSERT_TRUE(need_of(query, "VK_KHR_ray_query"));
    EXPECT_EQ(need_of(query, "rayQuery")->why, "trace refine transmit");

    // Each member is set where its struct is, and said not to be where that is missing.
    VkPhysicalDeviceVulkan13Features v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceFeatures2 chain{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &v13};
    std::set<std::string> left;
    for (const Requirement& r : query)
        if (!enable(r, chain) && r.kind == Requirement::Kind::feature) left.insert(r.name);
    EXPECT_TRUE(v13.synchronization2 && v13.maintenance4);
    EXPECT_TRUE(chain.features.shaderStorageImageExtendedFormats && !chain.features.shaderFloat64);
    EXPECT_TRUE(left.contains("rayQuery")) << "an extension's";
    EXPECT_FALSE(left.contains("maintenance4"));
    VkPhysicalDeviceFeatures2 alone{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
    EXPECT_FALSE(enable(*need_of(query, "maintenance4"), alone));

    Plan huge = *plan;
    huge.resources.front().extent = {1u << 20, 1};
    const auto missing = unmet(huge, handles_of(gpu()));
    ASSERT_EQ(missing.size(), 1u);
    EXPECT_EQ(missing[0].name, "maxImageDimension2D");
    EXPECT_EQ(missing[0].why, huge.resources.front().names.front());

    // What a shader of the host's declares and penumbra does not know is said, and is never there.
    Plan strange = *plan;
    std::vector<uint32_t>& spirv = strange.modules.at(*strange.passes.front().module);
    const uint32_t input_attachment[] = {2u << 16 | 17u, 40u};
    spirv.insert(spirv.begin() + 5, std::begin(input_attachment), std::end(input_attachment));
    const auto unknown = unmet(strange, handles_of(gpu()));
    ASSERT_EQ(unknown.size(), 1u);
    EXPECT_EQ(unknown[0].name, "SPIR-V capability 40");
    EXPECT_EQ(unknown[0].why, strange.passes.front().node);
    spirv[6] = 25;
    EXPECT_TRUE(need_of(requirements(strange), "shaderImageGatherExtended"));
}

TEST_F(HostAsksGpu, SlotsSayWhatTheHostMayBring) {
    const CheckedPipeline pipeline = shipped_pipeline("shadows");
    Diagnostics diagnostics;
    const auto plan = compile(pipeline, {.extent = {64, 32}, .device = reference_device()}, {}, diagnostics);
    ASSERT_TRUE(plan) << diagnostics.text();
    for (const HostSlot& slot : plan->slots) {
        const bool texels = slot.kind == PortKind::image || slot.kind == PortKind::texels;
        EXPECT_EQ(!slot.accepted.empty(), texels) << slot.name;
        if (texels) {
            EXPECT_NE(std::ranges::find(slot.accepted, slot.format), slot.accepted.end()) << slot.name;
        }
        EXPECT_NE(slot.use.stages, 0u) << slot.name;
        EXPECT_FALSE(slot.use.write);
        EXPECT_EQ(plan->slots[*plan->slot(slot.name)].name, slot.name);
    }
    EXPECT_GT(plan->slots[*plan->slot("depth")].accepted.size(), 1u);
    EXPECT_EQ(plan->slots[*plan->slot("sun")].use.access, VK_ACCESS_2_UNIFORM_READ_BIT);
}

void usage(const std::function<void()>& function, const std::string& place, const std::string& text) {
    const auto error = attempt(function);
    ASSERT_TRUE(error) << place;
    EXPECT_EQ(error->code, ErrorCode::usage) << to_string(*error);
    EXPECT_EQ(error->result, VK_SUCCESS);
    EXPECT_EQ(error->place, place);
    EXPECT_NE(error->text.find(text), std::string::npos) << error->text;
}

// Whatever the host gets wrong is its own mistake, in a place, and never Vulkan's.
TEST_F(HostAsksGpu, AHostsMistakesAreItsOwn) {
    const CheckedPipeline pipeline = checked(given_and_history);
    const auto plan = plan_of(pipeline, capturing(pipeline));
    DeviceHandles none = handles_of(gpu());
    none.device = VK_NULL_HANDLE;
    usage([&] { Program(none, plan); }, "DeviceHandles::device", "null");
    none = handles_of(gpu());
    none.get_instance_proc_addr = nullptr;
    usage([&] { Program(none, plan); }, "DeviceHandles::get_instance_proc_addr", "null");
    usage([&] { unmet(*plan, none); }, "DeviceHandles::get_instance_proc_addr", "null");
    usage([&] { Program(handles_of(gpu()), nullptr); }, "Program", "null");
    usage([&] { View(nullptr, {}); }, "View", "null");
    none = handles_of(gpu());
    none.get_instance_proc_addr = +[](VkInstance instance, const char* name) -> PFN_vkVoidFunction {
        return std::strcmp(name, "vkGetPhysicalDeviceProperties") ? vkGetInstanceProcAddr(instance, name)
                                                                  : nullptr;
    };
    usage([&] { Program(none, plan); }, "vkGetPhysicalDeviceProperties", "does not give it");
    none = handles_of(gpu());
    none.queue_family = 99;
    usage([&] { Program(none, plan); }, "DeviceHandles::queue_family", "99");
    none = handles_of(gpu());
    none.memory.allocate = [](const MemoryRequest&, MemoryBlock&) { return VK_SUCCESS; };
    usage([&] { Program(none, plan); }, "DeviceHandles::memory", "one of its two");

    const auto program = std::make_shared<Program>(handles_of(gpu()), plan);
    usage([&] { View(program, {.frames_in_flight = 0}); }, "ViewOptions::frames_in_flight", "0");
    usage([&] { View(program, {.poison = 0}); }, "ViewOptions::poison", "compiled with");
    const Device second({});
    const View theirs(std::make_shared<Program>(handles_of(second), plan), {});
    usage([&] { View(program, {.heir_of = &theirs}); }, "ViewOptions::heir_of", "another device");
    View view(program, {});
    Externals externals(*plan);
    usage([&] { externals["givn"]; }, "p", "did you mean \"given\"?");
    usage([&] { view.output("nothing"); }, "\"nothing\"", "no such output");
    usage([&] { view.captured("given"); }, "\"given\"", "does not capture");
    EXPECT_TRUE(view.statistics().empty());
    EXPECT_TRUE(view.captured(plan->outputs.front().name).empty());
    gpu().run([&](VkCommandBuffer cmd) {
        usage([&] { view.record(cmd, description(0), externals); }, "the slot \"given\"", "nothing is bound");
        FrameDescription wrong = description(0);
        wrong.size = {3000, 3000};
        usage([&] { view.record(cmd, wrong, externals); }, "p", "3000x3000");
        const auto refused = [&](auto&& spoil, const char* member, const char* text) {
            wrong = description(0);
            spoil(wrong);
            usage([&] { view.record(cmd, wrong, externals); }, fmt::format("FrameDescription::{}", member),
                  text);
        };
        refused([](auto& f) { f.camera.position[1] = NAN; }, "camera.position", "not finite");
        refused([](auto& f) { f.camera.clip_from_view[0] = INFINITY; }, "camera.clip_from_view",
                "not finite");
        refused([](auto& f) { f.camera.clip_from_view[5] = 0; }, "camera.clip_from_view", "no inverse");
        refused([](auto& f) { f.camera.clip_from_view[1] = 0.1; }, "camera.clip_from_view", "turned");
        refused([](auto& f) { f.camera.clip_from_view[11] = 1; }, "camera.clip_from_view", "-z");
        refused([](auto& f) { f.flags = frame_orthographic; }, "camera.clip_from_view", "orthographic");
        refused([](auto& f) { f.camera.near_m = NAN; }, "camera.near_m", "not finite");
        refused([](auto& f) { f.dt_s = INFINITY; }, "dt_s", "not finite");
        refused([](auto& f) { f.camera.world_from_view = {}; }, "camera.world_from_view", "no rotation");
        refused([](auto& f) { f.camera.world_from_view[0] = 2; }, "camera.world_from_view", "no rotation");
        refused([](auto& f) { f.jitter = {0, NAN}; }, "jitter", "units of the image");
        refused([](auto& f) { f.jitter = {0.5, 0.25}; }, "jitter", "units of the image");
        refused([](auto& f) { f.prev_jitter = {5, 0}; }, "prev_jitter", "more than the image");
        refused([](auto& f) { f.jitter = {0.001, 0}; }, "jitter", "Target::jitters");
        refused([](auto& f) { f.flags = 64; }, "flags", "0x40");
        refused([](auto& f) { f.sub_pixel_bits = 99; }, "sub_pixel_bits", "99");
        usage([&] { view.record_pass(cmd, 0); }, "p", "in order");
        usage([&] { view.end(cmd); }, "p", "behind begin()");
        externals["given"].image = reinterpret_cast<VkImageView>(1);  // is never looked at
        externals["given"].handover = Handover{};
        usage([&] { view.record(cmd, description(0), externals); }, "the slot \"given\"", "Handover::image");
        Handover& handover = *externals["given"].handover;
        handover.image = reinterpret_cast<VkImage>(1);
        handover.layout_before = VK_IMAGE_LAYOUT_UNDEFINED;
        usage([&] { view.record(cmd, description(0), externals); }, "the slot \"given\"", "would lose");
        handover.layout_before = handover.layout_after;
        handover.layout_after = VK_IMAGE_LAYOUT_UNDEFINED;
        usage([&] { view.record(cmd, description(0), externals); }, "the slot \"given\"", "handed back");
        handover.layout_after = handover.layout_before;
        handover.family_after = 77;
        usage([&] { view.record(cmd, description(0), externals); }, "the slot \"given\"", "queue family 77");
        handover.family_after = VK_QUEUE_FAMILY_IGNORED;
        externals["given"].layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
        usage([&] { view.record(cmd, description(0), externals); }, "the slot \"given\"", "layout");
        usage([&] { view.record(cmd, FrameDescription{}, externals); }, "p", "0x0");
    });
    usage([&] { view.record(VK_NULL_HANDLE, description(0), externals); }, "p", "command buffer");
    usage([&] { program->record_uploads(VK_NULL_HANDLE); }, "Program::record_uploads", "null");
}

// What a plan knows of its frames is held against what the host says of one.
TEST_F(HostAsksGpu, AFrameIsWhatThePlanAsksFor) {
    const auto pipeline = open_pipeline(PENUMBRA_SOURCE_DIR "/pipelines/raw.json", {}, shadow_nodes());
    ASSERT_TRUE(pipeline);
    const auto raw = plan_of(*pipeline, {});
    EXPECT_TRUE(raw->camera);
    View seeing(std::make_shared<Program>(handles_of(gpu()), raw), {});
    const auto blind =
        plan_of(checked(R"("outputs": ["value"], "nodes": { "fill": { "type": "toy_fill" } })"), {});
    EXPECT_FALSE(blind->camera);
    View view(std::make_shared<Program>(handles_of(gpu()), blind), {});
    FrameDescription frame = description(0);
    frame.camera.clip_from_view = frame.previous.clip_from_view = {};
    gpu().run([&](VkCommandBuffer cmd) {
        usage([&] { seeing.record(cmd, frame, Externals(*raw)); }, "FrameDescription::camera.clip_from_view",
              "\"raw\" asks for a camera");
        view.record(cmd, frame, {});
    });
    frame = description(1);
    frame.flags = frame_unchanged;
    frame.previous = frame.camera;
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, frame, {}); });
    frame.camera.position[0] += 1e-9;
    gpu().run([&](VkCommandBuffer cmd) {
        usage([&] { view.record(cmd, frame, {}); }, "FrameDescription::flags", "camera is not previous");
    });
}

// As many slots, of other names: the first of either would be bound to the other's.
TEST_F(HostAsksGpu, ExternalsOfAnotherPlanAreRefused) {
    const CheckedPipeline pipeline = checked(given_and_history);
    const auto plan = plan_of(pipeline, {}), alike = plan_of(pipeline, {.alias = false});
    const auto other =
        plan_of(checked(std::regex_replace(given_and_history, std::regex("given"), "another")), {});
    ASSERT_EQ(other->slots.size(), plan->slots.size());
    View view(std::make_shared<Program>(handles_of(gpu()), plan), {});
    Externals theirs(*other);
    EXPECT_TRUE(Externals(*alike).fits(*plan));
    gpu().run([&](VkCommandBuffer cmd) {
        usage([&] { view.record(cmd, description(0), theirs); }, "p", "another plan's");
        usage([&] { view.begin(cmd, description(0), theirs); }, "p", "another plan's");
    });
}

// What Vulkan would refuse of a block, or read beyond. Handles are never looked at: nothing is recorded.
TEST_F(HostAsksGpu, APartOfABufferThatCannotBeABlockIsRefused) {
    const auto pipeline = open_pipeline(PENUMBRA_SOURCE_DIR "/pipelines/raw.json", {}, shadow_nodes());
    ASSERT_TRUE(pipeline);
    const auto plan = plan_of(*pipeline, {});
    View view(std::make_shared<Program>(handles_of(gpu()), plan), {});
    Externals externals(*plan);
    for (const HostSlot& slot : plan->slots) {
        SlotBinding& b = externals[slot.name];
        b.image = reinterpret_cast<VkImageView>(1);
        b.texels = reinterpret_cast<VkBufferView>(1);
        b.buffer = reinterpret_cast<VkBuffer>(1);
        b.structure = reinterpret_cast<VkAccelerationStructureKHR>(1);
    }
    const auto refused = [&](VkDeviceSize offset, VkDeviceSize range, const std::string& text) {
        externals["sun"].offset = offset;
        externals["sun"].range = range;
        gpu().run([&](VkCommandBuffer cmd) {
            usage([&] { view.record(cmd, description(0), externals); }, "the slot \"sun\"", text);
        });
    };
    refused(0, 4, "4 bytes are bound to it, of a block of");
    refused(0, 0, "0 bytes");
    refused(1, VK_WHOLE_SIZE, "no multiple");
    externals["sun"].offset = 0;
    const auto texels = std::ranges::find(plan->slots, PortKind::texels, &HostSlot::kind);
    ASSERT_NE(texels, plan->slots.end());
    externals[texels->name].handover = Handover{};
    externals[texels->name].range = 0;
    gpu().run([&](VkCommandBuffer cmd) {
        usage([&] { view.record(cmd, description(0), externals); }, "the slot \"" + texels->name + "\"",
              "0 bytes is handed over");
    });
}

// Who forgets the camera of the frame before would have no history that fits.
TEST_F(HostAsksGpu, APreviousCameraIsAskedForWhereThereIsAFrameBefore) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    View view(std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline))), {});
    ASSERT_FALSE(view.plan().reset.empty());
    FrameDescription frame = description(0);
    frame.previous.clip_from_view = {};
    gpu().run([&](VkCommandBuffer cmd) { EXPECT_NO_THROW(view.record(cmd, frame, {})); });
    gpu().run([&](VkCommandBuffer cmd) {
        usage([&] { view.record(cmd, frame, {}); }, "FrameDescription::previous.clip_from_view",
              "no inverse");
        frame.flags = frame_reset;
        EXPECT_NO_THROW(view.record(cmd, frame, {}));
    });
    View heir(std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline))),
              {.heir_of = &view});
    frame.flags = 0;
    gpu().run([&](VkCommandBuffer cmd) {
        usage([&] { heir.record(cmd, frame, {}); }, "FrameDescription::previous.clip_from_view",
              "no inverse");
        frame = {.size = frame.size, .index = 2};
        EXPECT_NO_THROW(view.record(cmd, frame, {})) << "a pipeline may ask for no camera";
    });
}

// The host's past is one, too.
TEST_F(HostAsksGpu, APreviousCameraIsAskedForWhereTheHostBringsThePast) {
    const auto plan = plan_of(
        checked(R"("inputs": { "given": { "format": "r32f", "history": "host" } }, "outputs": ["blended"],
        "nodes": { "blend": { "type": "toy_blend", "in": { "value": "given@-1" } } })"),
        {});
    ASSERT_TRUE(plan->reset.empty());
    View view(std::make_shared<Program>(handles_of(gpu()), plan), {});
    GpuImage given = image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_SAMPLED_BIT);
    const std::vector<float> zeros(width * height);
    upload_image(gpu(), given, std::as_bytes(std::span(zeros)));
    Externals externals(*plan);
    externals["given@-1"].image = given.view.get();
    FrameDescription frame = description(0);
    frame.previous.clip_from_view = {};
    gpu().run([&](VkCommandBuffer cmd) { EXPECT_NO_THROW(view.record(cmd, frame, externals)); });
    gpu().run([&](VkCommandBuffer cmd) {
        usage([&] { view.record(cmd, frame, externals); }, "FrameDescription::previous.clip_from_view",
              "no inverse");
    });
}

TEST_F(HostAsksGpu, AFrameThatWasBegunIsEndedOrThrownAway) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    View view(std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, {})), {});
    const auto begin = [&](uint32_t flags) {
        gpu().run([&](VkCommandBuffer cmd) {
            FrameDescription frame = description(0);
            frame.flags = flags;
            view.begin(cmd, frame, std::span<const SlotBinding>{});
            view.record_pass(cmd, 0);
        });
    };
    begin(0);
    usage([&] { begin(0); }, view.plan().pipeline, "not ended");
    gpu().run([&](VkCommandBuffer cmd) {
        usage([&] { view.record(cmd, description(0), {}); }, view.plan().pipeline, "not ended");
    });
    EXPECT_NO_THROW(begin(frame_reset));
}

TEST_F(HostAsksGpu, ATargetThatTellsNothingOfItsDeviceIsADiagnostic) {
    const CheckedPipeline pipeline = checked(given_and_history);
    Diagnostics diagnostics;
    EXPECT_FALSE(compile(pipeline, {.extent = {width, height}}, {}, diagnostics));
    EXPECT_NE(diagnostics.text().find("Target::device tells nothing"), std::string::npos);
}

// Offsets are one device's: a plan for another would bind images on top of each other.
TEST_F(HostAsksGpu, APlanForAnotherDeviceIsRefused) {
    const CheckedPipeline pipeline = checked(given_and_history);
    const Plan plan = *plan_of(pipeline, {});
    const auto refused = [&](auto&& change, const std::string& text) {
        Plan other = plan;
        change(other);
        usage([&] { Program(handles_of(gpu()), std::make_shared<const Plan>(other)); }, "p", text);
    };
    refused([](Plan& p) { p.device = reference_device().name; }, "device_table(handles)");
    refused([](Plan& p) { p.resources.back().bytes -= 1; }, "\"" + plan.resources.back().names.back() + "\"");
    refused([](Plan& p) { p.resources.back().alignment /= 2; }, "other memory");
    refused([](Plan& p) { p.heaps[p.resources.back().heap].memory_type_bits ^= 1; }, "other memory");
    const Device second({});
    const auto sharing = plan_of(pipeline, {.share_transients = true});
    const auto theirs = Program(handles_of(second), sharing).make_transients();
    const auto program = std::make_shared<Program>(handles_of(gpu()), sharing);
    usage([&] { View(program, {.transients = theirs}); }, "ViewOptions::transients", "another device");

    const CheckedPipeline toy = toy_pipeline_file();
    const auto alone = std::make_shared<Program>(handles_of(gpu()), plan_of(toy, {}));
    const auto ours = program->make_transients();
    usage([&] { alone->make_transients(); }, "make_transients", "CompileOptions::share_transients");
    usage([&] { View(alone, {.transients = ours}); }, "ViewOptions::transients",
          "CompileOptions::share_transients");
}

// A part of a buffer of the host's: the shader sees that part, from its beginning to its end. Counters come
// back in their order.
TEST_F(HostAsksGpu, ABuffersPartIsWhatIsBound) {
    const TestFolder folder;
    std::ofstream(folder / "toy_part.json") << R"({ "node": "toy_part", "doc": "d", "shader": "toy_part.comp",
        "inputs": { "numbers": { "kind": "buffer", "element": "u32" } },
        "outputs": { "value": { "kind": "image", "format": "r32f" } },
        "dispatch": { "over": "value", "group": [8, 8] }, "counters": ["pixels", "even"] })";
    std::ofstream(folder / "toy_part.comp") << R"(#include "node.glsl"
void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(value)))) return;
    count_pixels(1u);
    count_even(p.x % 2 == 0 ? 1u : 0u);
    imageStore(value, p, vec4(float(numbers[0]) + 100.0 * float(numbers.length())));
})";
    NodeSet set;
    Diagnostics diagnostics;
    ASSERT_TRUE(add_user_nodes(set, folder, diagnostics, open_shader_cache(""))) << diagnostics.text();
    const CheckedPipeline pipeline = checked(
        R"("inputs": { "numbers": {} }, "outputs": ["value"], "nodes": { "part": { "type": "toy_part" } })",
        set);
    View view(std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline))), {});
    const GpuBuffer buffer = make_host_buffer(gpu(), 1024, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "numbers");
    for (uint32_t i = 0; i < 256; ++i) static_cast<uint32_t*>(buffer.mapped)[i] = i;
    Externals externals(view.plan());
    externals["numbers"] = {.buffer = buffer.get(), .offset = 256, .range = 12};
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(0), externals); });
    EXPECT_EQ(floats(view.captured("value"))[3], 64.0f + 300.0f);
    EXPECT_EQ(view.statistics()[0].counters,
              (std::vector<uint32_t>{width * height, (width + 1) / 2 * height}));
}

// A ring of all blocks, say, which is larger than what a uniform buffer may show at once.
TEST_F(HostAsksGpu, OfALargeBufferNoMoreIsBoundThanABlockTakes) {
    const TestFolder folder;
    std::ofstream(folder / "toy_lit.json") << R"({ "node": "toy_lit", "doc": "d", "shader": "toy_lit.comp",
        "inputs": { "sun": { "kind": "block", "element": "Sun" } },
        "outputs": { "value": { "kind": "image", "format": "r32f" } },
        "dispatch": { "over": "frame", "group": [8, 8] } })";
    std::ofstream(folder / "toy_lit.comp") << R"(#include "node.glsl"
#include "common/pixels.glsl"
void for_pixel(ivec2 p) { imageStore(value, p, vec4(sun.angular_radius)); }
void main() { for_each_pixel(); }
)";
    NodeSet set = shadow_nodes();
    Diagnostics diagnostics;
    ASSERT_TRUE(add_user_nodes(set, folder, diagnostics, open_shader_cache(""))) << diagnostics.text();
    const CheckedPipeline pipeline = checked(
        R"("inputs": { "sun": {} }, "outputs": ["value"], "nodes": { "lit": { "type": "toy_lit" } })", set);
    View view(std::make_shared<Program>(Spy::handles(), plan_of(pipeline, capturing(pipeline))), {});
    constexpr VkDeviceSize at = 1 << 20;
    const GpuBuffer ring = make_host_buffer(gpu(), 4 * at, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, "a ring");
    const float sun[4] = {0, 1, 0, 0.25f};
    std::memcpy(static_cast<std::byte*>(ring.mapped) + at, sun, sizeof sun);
    Externals externals(view.plan());
    externals["sun"] = {.buffer = ring.get(), .offset = at};
    Spy::blocks.clear();
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(0), externals); });
    EXPECT_EQ(floats(view.captured("value"))[3], 0.25f);
    ASSERT_EQ(Spy::blocks.size(), 1u);
    EXPECT_EQ(Spy::blocks[0].buffer, ring.get());
    EXPECT_EQ(Spy::blocks[0].offset, at);
    EXPECT_EQ(Spy::blocks[0].range, sizeof sun);
}

// The pool of descriptors has room for what is taken from it and for no more: few drivers say where it has
// not.
TEST_F(HostAsksGpu, DescriptorPoolsFit) {
    const auto program = std::make_shared<Program>(Spy::handles(), plan_of(toy_pipeline_file(), {}));
    for (const uint32_t n : {1u, 3u}) {
        Spy::sets = Spy::room = 0;
        Spy::descriptors.clear();
        View view(program, {.frames_in_flight = n});
        EXPECT_EQ(Spy::sets, Spy::room);
        std::map<VkDescriptorType, uint32_t> expected;
        for (const PlanPass& pass : program->plan().passes)
            for (const PlanBinding& b : pass.bindings)
                expected[b.type] += b.set ? n : 2 * std::max<uint32_t>(uint32_t(pass.level_groups.size()), 1);
        EXPECT_EQ(Spy::descriptors, expected);
    }
}

// A host that builds acceleration structures orders that itself: they have no layout and no queue of their
// own.
TEST_F(HostAsksGpu, AnAccelerationStructureIsNotHandedOver) {
    NodeSet set;
    NodeEntry looks;
    looks.type =
        parse_toy(R"({ "node": "looks", "doc": "d", "host": true, "inputs": { "scene": { "kind": "scene" } },
      "outputs": { "seen": { "kind": "image", "format": "r32f" } },
      "params": { "backend": { "type": "enum", "values": ["auto", "bvh", "ray_query"], "default": "ray_query",
                               "constant": true, "doc": "d" } } })",
                  "looks");
    looks.callback = [](const HostPassContext&) {};
    set.add(std::move(looks));
    const CheckedPipeline pipeline = checked(
        R"("inputs": { "scene": {} }, "outputs": ["seen"], "nodes": { "looks": { "type": "looks" } })", set);
    Target target{
        .extent = {width, height}, .facts = {{"alpha", false}}, .device = device_table(handles_of(gpu()))};
    target.device.features = {"ray_query"};
    Diagnostics diagnostics;
    const auto plan = compile(pipeline, target, {}, diagnostics);
    ASSERT_TRUE(plan) << diagnostics.text();
    View view(std::make_shared<Program>(handles_of(gpu()), std::make_shared<const Plan>(*plan)), {});
    Externals externals(view.plan());
    for (const HostSlot& slot : view.plan().slots) {  // never looked at
        externals[slot.name].buffer = reinterpret_cast<VkBuffer>(1);
        externals[slot.name].structure = reinterpret_cast<VkAccelerationStructureKHR>(1);
    }
    ASSERT_TRUE(externals.has("scene.tlas"));
    externals["scene.tlas"].handover = Handover{};
    const auto error = attempt(
        [&] { gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(0), externals); }); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, ErrorCode::usage);
    EXPECT_EQ(error->place, "the slot \"scene.tlas\"");
    EXPECT_NE(error->text.find("cannot be handed over"), std::string::npos) << error->text;
}

}  // namespace
}  // namespace penumbra::test
