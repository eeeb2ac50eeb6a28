// SPDX-License-Identifier: MIT
// Penumbra on a host's own objects: functions, memory, images that are handed over, several graphs and views,
// and what is said where the host is wrong.
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <thread>

#include "app/session.h"
#include "host/device/gpu.h"
#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"
#include "penumbra/user_nodes.h"
#include "tests/gpu_test.h"
#include "tests/toy_nodes.h"
#include "tests/toy_set.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr uint32_t width = 29, height = 13;

CheckedPipeline checked(const std::string& body, const NodeSet& set = toy_set()) {
    Diagnostics diagnostics;
    const auto pipeline =
        parse_pipeline(R"({ "penumbra": 1, "name": "p", )" + body + "}", "p.json", {}, diagnostics);
    auto result = pipeline ? check(*pipeline, set, diagnostics) : std::nullopt;
    if (!result) throw std::runtime_error(diagnostics.text());
    return std::move(*result);
}

const char* const given_and_history = R"("inputs": { "given": { "format": "r32f" } }, "outputs": ["blended"],
    "nodes": { "blend": { "type": "toy_blend", "in": { "value": "given", "history": "blended@-1" } } })";

std::shared_ptr<const Plan> plan_of(const CheckedPipeline& pipeline, const CompileOptions& options) {
    Diagnostics diagnostics;
    auto plan = compile(pipeline, {.extent = {width, height}, .device = device_table(handles_of(gpu()))},
                        options, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::make_shared<const Plan>(std::move(*plan));
}

CompileOptions capturing(const CheckedPipeline& pipeline, bool share = false) {
    CompileOptions options;
    options.captures = pipeline.output_names();
    options.share_transients = share;
    return options;
}

FrameDescription description(uint32_t index) {
    FrameDescription frame;
    frame.camera.clip_from_view = frame.previous.clip_from_view = perspective(1.0, 1.0, 0.1);
    frame.size = frame.prev_size = {width, height};
    frame.index = index;
    return frame;
}

std::vector<float> floats(std::span<const std::byte> bytes) {
    std::vector<float> values(bytes.size() / sizeof(float));
    std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
}

using Outputs = std::map<std::string, std::vector<float>>;
Outputs outputs_of(const View& view) {
    Outputs outputs;
    for (const PlanOutput& output : view.plan().outputs)
        outputs[output.name] = floats(view.captured(output.name));
    return outputs;
}

class EmbeddingGpu : public GpuTest {};

// --- Vulkan's functions -----------------------------------------------------------------------------------

// The functions that were asked for, and the barriers that belong to another queue family, which are not
// passed on: this device has but one.
struct Spy {
    static inline std::set<std::string> asked;
    static inline std::vector<VkImageMemoryBarrier2> transfers;
    static inline std::vector<std::byte> cache;  // that a program was made with

    static inline std::set<std::string> names, labels;  // of objects, of what passes record
    static VKAPI_ATTR VkResult VKAPI_CALL set_name(VkDevice, const VkDebugUtilsObjectNameInfoEXT* info) {
        names.insert(info->pObjectName);
        return VK_SUCCESS;
    }
    static VKAPI_ATTR void VKAPI_CALL begin_label(VkCommandBuffer, const VkDebugUtilsLabelEXT* info) {
        labels.insert(info->pLabelName);
    }
    static VKAPI_ATTR void VKAPI_CALL end_label(VkCommandBuffer) {}

    static VKAPI_ATTR VkResult VKAPI_CALL make_cache(VkDevice device, const VkPipelineCacheCreateInfo* info,
                                                     const VkAllocationCallbacks* callbacks,
                                                     VkPipelineCache* handle) {
        const auto* data = static_cast<const std::byte*>(info->pInitialData);
        cache.assign(data, data + info->initialDataSize);
        return vkCreatePipelineCache(device, info, callbacks, handle);
    }

    static VKAPI_ATTR void VKAPI_CALL barrier(VkCommandBuffer cmd, const VkDependencyInfo* info) {
        if (info->imageMemoryBarrierCount > 0 &&
            info->pImageMemoryBarriers[0].srcQueueFamilyIndex != VK_QUEUE_FAMILY_IGNORED)
            transfers.insert(transfers.end(), info->pImageMemoryBarriers,
                             info->pImageMemoryBarriers + info->imageMemoryBarrierCount);
        else
            vkCmdPipelineBarrier2(cmd, info);
    }
    static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_device(VkDevice device, const char* name) {
        asked.insert(name);
        if (!std::strcmp(name, "vkCmdPipelineBarrier2")) return reinterpret_cast<PFN_vkVoidFunction>(barrier);
        if (!std::strcmp(name, "vkSetDebugUtilsObjectNameEXT"))
            return reinterpret_cast<PFN_vkVoidFunction>(set_name);
        if (!std::strcmp(name, "vkCmdBeginDebugUtilsLabelEXT"))
            return reinterpret_cast<PFN_vkVoidFunction>(begin_label);
        if (!std::strcmp(name, "vkCmdEndDebugUtilsLabelEXT"))
            return reinterpret_cast<PFN_vkVoidFunction>(end_label);
        if (!std::strcmp(name, "vkCreatePipelineCache"))
            return reinterpret_cast<PFN_vkVoidFunction>(make_cache);
        return vkGetDeviceProcAddr(device, name);
    }
    static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_instance(VkInstance instance, const char* name) {
        asked.insert(name);
        if (!std::strcmp(name, "vkGetDeviceProcAddr")) return reinterpret_cast<PFN_vkVoidFunction>(of_device);
        return vkGetInstanceProcAddr(instance, name);
    }
    static DeviceHandles handles() {
        asked.clear();
        transfers.clear();
        DeviceHandles handles = handles_of(gpu());
        handles.get_instance_proc_addr = of_instance;
        return handles;
    }
};

GpuImage image_of(VkFormat format, VkImageUsageFlags usage) {
    return make_image(gpu(), format, {width, height}, 1, usage | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                      "the host's");
}

TEST_F(EmbeddingGpu, AnotherQueuesImageIsAcquiredAndReleased) {
    const CheckedPipeline pipeline = checked(given_and_history);
    const auto program = std::make_shared<Program>(Spy::handles(), plan_of(pipeline, capturing(pipeline)));
    EXPECT_TRUE(Spy::asked.contains("vkCmdDispatch"));
    View view(program, {});
    const GpuImage given = image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_SAMPLED_BIT);
    const uint32_t own = gpu().queue_family(), theirs = own + 7;
    Externals externals(view.plan());
    externals["given"] = {.image = given.view.get(),
                          .handover = Handover{.image = given.get(),
                                               .stages_before = VK_PIPELINE_STAGE_2_COPY_BIT,
                                               .access_before = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                               .layout_before = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                               .layout_after = VK_IMAGE_LAYOUT_GENERAL,
                                               .family_before = theirs,
                                               .family_after = theirs}};
    const std::vector<float> zeros(width * height);
    GpuImage filled = image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_SAMPLED_BIT);
    upload_image(gpu(), filled, std::as_bytes(std::span(zeros)));  // for its layout: the barriers are not run
    externals["given"].image = filled.view.get();
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(0), externals); });
    ASSERT_EQ(Spy::transfers.size(), 2u);
    const VkImageMemoryBarrier2 &acquire = Spy::transfers[0], &release = Spy::transfers[1];
    EXPECT_EQ(acquire.srcQueueFamilyIndex, theirs);
    EXPECT_EQ(acquire.dstQueueFamilyIndex, own);
    EXPECT_EQ(acquire.oldLayout, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    EXPECT_EQ(acquire.newLayout, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    EXPECT_EQ(acquire.srcStageMask, VK_PIPELINE_STAGE_2_NONE);  // the release's, on the other queue
    EXPECT_EQ(acquire.dstStageMask, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT);
    EXPECT_EQ(acquire.image, given.get());
    EXPECT_EQ(release.srcQueueFamilyIndex, own);
    EXPECT_EQ(release.dstQueueFamilyIndex, theirs);
    EXPECT_EQ(release.oldLayout, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    EXPECT_EQ(release.newLayout, VK_IMAGE_LAYOUT_GENERAL);
    EXPECT_EQ(release.srcStageMask, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT);
}

TEST_F(EmbeddingGpu, DebuggersAreToldTheNames) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    Spy::names.clear();
    Spy::labels.clear();
    View view(std::make_shared<Program>(Spy::handles(), plan_of(pipeline, {})), {});
    for (const char* name : {"blended@0", "blended@1", "scattered", "list", "chain", "the frame block"})
        EXPECT_TRUE(Spy::names.contains(name)) << name;
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(0), {}); });
    for (const PlanPass& pass : view.plan().passes) EXPECT_TRUE(Spy::labels.contains(pass.node)) << pass.node;
}

// --- Images of the host -----------------------------------------------------------------------------------

// The host clears an image and copies out of it, in the layouts of those commands; in between the frame reads
// it. Nothing but the handover orders the three, and synchronisation validation listens.
TEST_F(EmbeddingGpu, AnImageComesAndGoesInTheHostsLayouts) {
    const CheckedPipeline pipeline = checked(given_and_history);
    View view(std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline))), {});
    const GpuImage given =
        image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    const GpuBuffer copy =
        make_host_buffer(gpu(), 4 * width * height, VK_BUFFER_USAGE_TRANSFER_DST_BIT, "copy");
    Externals externals(view.plan());
    EXPECT_TRUE(externals.has("given"));
    externals["given"] = {.image = given.view.get(),
                          .handover = Handover{.image = given.get(),
                                               .stages_before = VK_PIPELINE_STAGE_2_CLEAR_BIT,
                                               .stages_after = VK_PIPELINE_STAGE_2_COPY_BIT,
                                               .access_before = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                               .access_after = VK_ACCESS_2_TRANSFER_READ_BIT,
                                               .layout_before = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                               .layout_after = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL}};
    float expected = 0;
    for (uint32_t f = 0; f < 3; ++f) {
        gpu().run([&](VkCommandBuffer cmd) {
            constexpr VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
            VkImageMemoryBarrier2 fresh{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
            fresh.dstStageMask = VK_PIPELINE_STAGE_2_CLEAR_BIT;
            fresh.dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
            fresh.newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
            fresh.image = given.get();
            fresh.subresourceRange = all;
            VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
            dependency.imageMemoryBarrierCount = 1;
            dependency.pImageMemoryBarriers = &fresh;
            vkCmdPipelineBarrier2(cmd, &dependency);
            VkClearColorValue colour{};
            colour.float32[0] = static_cast<float>(f + 1);
            vkCmdClearColorImage(cmd, given.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &colour, 1, &all);
            view.record(cmd, description(f), externals);
            VkBufferImageCopy region{};
            region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
            region.imageExtent = {width, height, 1};
            vkCmdCopyImageToBuffer(cmd, given.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, copy.get(), 1,
                                   &region);
        });
        expected = static_cast<float>(f + 1) + expected / 2;
        EXPECT_EQ(floats(view.captured("blended")), std::vector<float>(width * height, expected)) << f;
        EXPECT_EQ(static_cast<const float*>(copy.mapped)[7], static_cast<float>(f + 1));
    }
}

// "value" is put into images of the host, another one every frame, is read on within the frame, and goes back
// in the layout of a copy's source.
TEST_F(EmbeddingGpu, AnOutputIsPutIntoTheHostsImage) {
    const std::string body = R"("outputs": ["value", "blended"], "nodes": { "fill": { "type": "toy_fill" },
        "blend": { "type": "toy_blend", "in": { "history": "blended@-1" } } })";
    const CheckedPipeline pipeline = checked(body);
    CompileOptions options = capturing(pipeline);
    options.outputs["value"].host_image = true;
    const auto plan = plan_of(pipeline, options);
    EXPECT_TRUE(plan->slots[*plan->slot("value")].output);
    EXPECT_LT(plan->memory.unaliased_bytes, plan_of(pipeline, capturing(pipeline))->memory.unaliased_bytes);
    View view(std::make_shared<Program>(handles_of(gpu()), plan), {.frames_in_flight = 2});
    constexpr VkImageUsageFlags usage =
        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    const GpuImage own[2] = {image_of(VK_FORMAT_R32_SFLOAT, usage), image_of(VK_FORMAT_R32_SFLOAT, usage)};
    Externals externals(*plan);
    std::vector<float> blended(width * height, 0.0f);
    for (uint32_t f = 0; f < 5; ++f) {
        const GpuImage& image = own[f / 2 % 2];
        externals["value"] = {.image = image.view.get(),
                              .handover = Handover{.image = image.get(),
                                                   .stages_before = VK_PIPELINE_STAGE_2_COPY_BIT,
                                                   .stages_after = VK_PIPELINE_STAGE_2_COPY_BIT,
                                                   .access_after = VK_ACCESS_2_TRANSFER_READ_BIT,
                                                   .layout_after = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL}};
        gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(f), externals); });
        const auto bytes = read_image(gpu(), image.get(), VK_FORMAT_R32_SFLOAT, {width, height},
                                      VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        EXPECT_EQ(view.output("value").image, image.get());
        std::vector<float> value(width * height);
        for (uint32_t i = 0; i < value.size(); ++i) {
            value[i] = static_cast<float>(i + f);
            blended[i] = value[i] + 0.5f * blended[i];
        }
        EXPECT_EQ(floats(bytes), value) << f;
        EXPECT_EQ(floats(view.captured("value")), value) << f;
        EXPECT_EQ(floats(view.captured("blended")), blended) << f;
    }
    externals["value"].handover.reset();
    const auto error = attempt(
        [&] { gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(5), externals); }); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, ErrorCode::usage);
    EXPECT_EQ(error->place, "the slot \"value\"");
}

TEST_F(EmbeddingGpu, AnOutputWithAPastStaysPenumbras) {
    const CheckedPipeline pipeline = checked(given_and_history);
    CompileOptions options;
    options.outputs["blended"].host_image = true;
    Diagnostics diagnostics;
    EXPECT_FALSE(
        compile(pipeline, {.extent = {width, height}, .device = reference_device()}, options, diagnostics));
    EXPECT_NE(diagnostics.text().find("the next frame reads its previous value"), std::string::npos);
}

// --- Memory -----------------------------------------------------------------------------------------------

// A host's allocator: blocks inside larger allocations, mapped where asked for, and no more after so many.
class Allocator {
  public:
    HostMemory callbacks() {
        return {[this](const MemoryRequest& request, MemoryBlock& block) { return allocate(request, block); },
                [this](const MemoryBlock& block) { release(block); }};
    }
    size_t calls = 0, fail_at = ~size_t{0};
    VkResult failure = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    std::map<void*, MemoryBlock> live;

  private:
    VkResult allocate(const MemoryRequest& request, MemoryBlock& block) {
        if (++calls == fail_at) return failure;
        VkPhysicalDeviceMemoryProperties memory;
        vkGetPhysicalDeviceMemoryProperties(gpu().physical(), &memory);
        uint32_t type = 0;
        while (!(request.need.memoryTypeBits >> type & 1) ||
               (memory.memoryTypes[type].propertyFlags & request.properties) != request.properties)
            ++type;
        block.offset = (12345 / request.need.alignment + 1) * request.need.alignment;
        const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr,
                                        block.offset + request.need.size + 999, type};
        check(vkAllocateMemory(gpu().get(), &info, nullptr, &block.memory), "vkAllocateMemory", request.what);
        if (request.mapped) {
            check(vkMapMemory(gpu().get(), block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped), "vkMapMemory",
                  "");
            block.mapped = static_cast<std::byte*>(block.mapped) + block.offset;
        }
        block.user = block.memory;
        live[block.user] = block;
        return VK_SUCCESS;
    }
    void release(const MemoryBlock& block) {
        ASSERT_EQ(live.erase(block.user), 1u);
        vkFreeMemory(gpu().get(), block.memory, nullptr);
    }
};

Outputs run_toys(const DeviceHandles& handles, uint32_t frames) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    View view(std::make_shared<Program>(handles, plan_of(pipeline, capturing(pipeline))), {});
    for (uint32_t f = 0; f < frames; ++f)
        gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(f), {}); });
    return outputs_of(view);
}

TEST_F(EmbeddingGpu, MemoryComesFromTheHost) {
    Allocator allocator;
    DeviceHandles handles = handles_of(gpu());
    const Outputs expected = run_toys(handles, 3);
    handles.memory = allocator.callbacks();
    EXPECT_EQ(run_toys(handles, 3), expected);
    EXPECT_GT(allocator.calls, 3u);
    EXPECT_TRUE(allocator.live.empty());
}

// For every call that the allocator may fail: an error that says so, nothing left behind, and then it works.
TEST_F(EmbeddingGpu, AnAllocatorThatFailsLeavesNothingBehind) {
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

TEST_F(EmbeddingGpu, AnAllocatorThatBreaksItsWordIsTheHostsMistake) {
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

// --- Several of them --------------------------------------------------------------------------------------

// Four views take turns in one piece of shared memory, each with a past of its own.
TEST_F(EmbeddingGpu, ViewsThatTakeTurnsShareTransientsAndKeepTheirPasts) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    const auto program =
        std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline, true)));
    const Plan& plan = program->plan();
    ASSERT_GT(plan.memory.shared_bytes, 0u);
    for (const PlanResource& r : plan.resources)
        EXPECT_EQ(plan.heaps[r.heap].shared, !r.history && !r.output && !r.kept) << r.names.front();
    const auto transients = program->make_transients();
    EXPECT_EQ(bytes_of(*transients), plan.memory.shared_bytes);
    View alone(program, {});
    std::vector<std::unique_ptr<View>> views;
    for (uint32_t v = 0; v < 4; ++v) {
        views.push_back(std::make_unique<View>(program, ViewOptions{.transients = transients}));
        EXPECT_EQ(views[v]->bytes() + bytes_of(*transients), alone.bytes());
        EXPECT_TRUE(views[v]->set_param("fill", "scale", ParamValue(static_cast<float>(v + 1))));
    }
    std::vector<Outputs> expected;
    for (uint32_t v = 0; v < 4; ++v) {
        View own(program, {});
        EXPECT_TRUE(own.set_param("fill", "scale", ParamValue(static_cast<float>(v + 1))));
        for (uint32_t f = 0; f < 3; ++f)
            gpu().run([&](VkCommandBuffer cmd) { own.record(cmd, description(f), {}); });
        expected.push_back(outputs_of(own));
    }
    EXPECT_NE(expected[0], expected[1]);
    for (uint32_t f = 0; f < 3; ++f)  // in one command buffer, with nothing of the host's between them
        gpu().run([&](VkCommandBuffer cmd) {
            for (const auto& view : views) view->record(cmd, description(f), {});
        });
    for (uint32_t v = 0; v < 4; ++v) EXPECT_EQ(outputs_of(*views[v]), expected[v]) << v;
}

TEST_F(EmbeddingGpu, TransientsOfASmallerPlanAreRefused) {
    const CheckedPipeline small = checked(given_and_history), large = toy_pipeline_file();
    const auto of_small =
        Program(handles_of(gpu()), plan_of(small, capturing(small, true))).make_transients();
    const auto program = std::make_shared<Program>(handles_of(gpu()), plan_of(large, capturing(large, true)));
    const auto error = attempt([&] { View view(program, {.transients = of_small}); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, ErrorCode::usage);
    EXPECT_EQ(error->place, "ViewOptions::transients");
}

// A node that reads a table.
NodeSet set_with_table() {
    const std::filesystem::path folder =
        std::filesystem::path(::testing::TempDir()) / "penumbra_embedding_table";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "toy_table.json")
        << R"({ "node": "toy_table", "doc": "d", "shader": "toy_table.comp",
        "inputs": {}, "outputs": { "value": { "kind": "image", "format": "r32f" } },
        "tables": { "steps": { "file": "steps.bin", "format": "r32f", "extent": [4, 1] } },
        "dispatch": { "over": "value", "group": [8, 8] } })";
    std::ofstream(folder / "toy_table.comp") << R"(#include "node.glsl"
void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(value)))) return;
    imageStore(value, p, texelFetch(steps, ivec2(p.x % 4, 0), 0));
})";
    const float steps[4] = {3, 1, 4, 1.5f};
    std::ofstream(folder / "steps.bin", std::ios::binary)
        .write(reinterpret_cast<const char*>(steps), sizeof steps);
    NodeSet set;
    for (const std::string& name : toy_set().names()) set.add(*toy_set().find(name));
    Diagnostics diagnostics;
    if (!add_user_nodes(set, folder, diagnostics, open_shader_cache("")))
        throw std::runtime_error(diagnostics.text());
    return set;
}

// Command buffers that threads of a host record into.
struct Recorder {
    Recorder() {
        VkCommandPoolCreateInfo create{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
        create.queueFamilyIndex = gpu().queue_family();
        VkCommandPool handle = VK_NULL_HANDLE;
        check(vkCreateCommandPool(gpu().get(), &create, nullptr, &handle), "vkCreateCommandPool",
              "a thread's");
        pool = {gpu().get(), handle};
        VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
        allocate.commandPool = handle;
        allocate.commandBufferCount = 1;
        check(vkAllocateCommandBuffers(gpu().get(), &allocate, &cmd), "vkAllocateCommandBuffers",
              "a thread's");
    }
    template <class F>
    void record(F&& function) {
        check(vkResetCommandPool(gpu().get(), pool.get(), 0), "vkResetCommandPool", "a thread's");
        VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        check(vkBeginCommandBuffer(cmd, &begin), "vkBeginCommandBuffer", "a thread's");
        function(cmd);
        check(vkEndCommandBuffer(cmd), "vkEndCommandBuffer", "a thread's");
    }
    Owned<VkCommandPool> pool;
    VkCommandBuffer cmd = VK_NULL_HANDLE;
};

// Two graphs, of one of them two views, on three threads; their frames are submitted in either order, also
// the first ones, which both carry the upload of the tables.
TEST_F(EmbeddingGpu, ThreadsRecordViewsAndGraphsAtOnce) {
    const CheckedPipeline with_table = checked(
        R"("outputs": ["blended"], "nodes": { "table": { "type": "toy_table" },
           "blend": { "type": "toy_blend", "in": { "history": "blended@-1" } } })",
        set_with_table());
    const CheckedPipeline toys = toy_pipeline_file();
    const auto tables =
        std::make_shared<Program>(handles_of(gpu()), plan_of(with_table, capturing(with_table)));
    const auto other = std::make_shared<Program>(handles_of(gpu()), plan_of(toys, capturing(toys)));
    for (const bool backwards : {false, true}) {
        View views[3] = {View(tables, {}), View(tables, {}), View(other, {})};
        Recorder recorders[3];
        for (uint32_t f = 0; f < 4; ++f) {
            std::vector<std::thread> threads;
            for (size_t t = 0; t < 3; ++t)
                threads.emplace_back([&, t] {
                    recorders[t].record(
                        [&](VkCommandBuffer cmd) { views[t].record(cmd, description(f), {}); });
                });
            for (std::thread& thread : threads) thread.join();
            std::vector<VkCommandBuffer> order = {recorders[0].cmd, recorders[1].cmd, recorders[2].cmd};
            if (backwards) std::ranges::reverse(order);
            VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
            submit.commandBufferCount = 3;
            submit.pCommandBuffers = order.data();
            check(vkQueueSubmit(gpu().queue(), 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit", "threads");
            check(vkQueueWaitIdle(gpu().queue()), "vkQueueWaitIdle", "threads");
        }
        const float steps[4] = {3, 1, 4, 1.5f};
        std::vector<float> expected(width * height);
        for (uint32_t i = 0; i < expected.size(); ++i) expected[i] = 1.875f * steps[i % width % 4];
        EXPECT_EQ(floats(views[0].captured("blended")), expected) << backwards;
        EXPECT_EQ(floats(views[1].captured("blended")), expected) << backwards;
        EXPECT_EQ(outputs_of(views[2]), run_toys(handles_of(gpu()), 4)) << backwards;
    }
}

TEST_F(EmbeddingGpu, TablesMayBeUploadedAheadOfAllViews) {
    const CheckedPipeline pipeline =
        checked(R"("outputs": ["value"], "nodes": { "table": { "type": "toy_table" } })", set_with_table());
    const auto program = std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline)));
    EXPECT_GT(program->bytes(), 0u);
    gpu().run([&](VkCommandBuffer cmd) { program->record_uploads(cmd); });
    View view(program, {.tables_uploaded = true});
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(0), {}); });
    EXPECT_EQ(floats(view.captured("value"))[2], 4.0f);
}

// --- Change -----------------------------------------------------------------------------------------------

std::shared_ptr<const Program> program_with(const CheckedPipeline& pipeline, const Facts& facts,
                                            bool hand_on = true, Extent extent = {width, height}) {
    CompileOptions options = capturing(pipeline);
    options.hand_on_history = hand_on;
    Diagnostics diagnostics;
    auto plan =
        compile(pipeline, {.extent = extent, .facts = facts, .device = device_table(handles_of(gpu()))},
                options, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::make_shared<Program>(handles_of(gpu()), std::make_shared<const Plan>(std::move(*plan)));
}

// Facts change every few frames: each time another plan's view takes over, and all histories (an image, what
// is kept) go on as if there had been but one.
TEST_F(EmbeddingGpu, AnHeirGoesOnWhereTheViewBeforeHasStopped) {
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
}

TEST_F(EmbeddingGpu, AnHeirWithoutItsHistoryStartsAnewAndSaysWhy) {
    const CheckedPipeline first =
                              checked(R"("outputs": ["value"], "nodes": { "fill": { "type": "toy_fill" } })"),
                          second =
                              checked(R"("outputs": ["blended"], "nodes": { "fill": { "type": "toy_fill" },
        "blend": { "type": "toy_blend", "in": { "history": "blended@-1" } } })");
    const std::shared_ptr<const Program> heirs = program_with(second, {});
    const std::shared_ptr<const Program> before_them[] = {
        program_with(first, {}),                              // has none
        program_with(second, {}, true, {width + 1, height}),  // has another size
        program_with(second, {}, false)};                     // does not hand it on
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

// Sizes and facts change at random, two frames in flight. What both plans have goes on, another size begins
// anew; views retire by fences, all memory comes back, and nothing that waits or submits was so much as asked
// for.
TEST_F(EmbeddingGpu, TwoHundredRandomChangesWithFramesInFlight) {
    const CheckedPipeline pipeline = checked(R"("outputs": ["blended", "level"], "nodes": {
        "fill": { "type": "toy_fill" }, "blend": { "type": "toy_blend", "in": { "history": "blended@-1" } },
        "bright": { "type": "toy_fill", "if": "moves", "params": { "scale": 3 }, "out": { "value": "level" } },
        "dim": { "type": "toy_fill", "if": "!moves", "out": { "value": "level" } } })");
    constexpr Extent sizes[] = {{width, height}, {width + 7, height}, {width, height + 5}, {8, 8}};
    Allocator allocator;
    DeviceHandles handles = Spy::handles();
    handles.memory = allocator.callbacks();
    {
        std::map<std::pair<size_t, bool>, std::shared_ptr<const Program>> programs;
        const auto program_for = [&](size_t size, bool moves) {
            std::shared_ptr<const Program>& program = programs[{size, moves}];
            if (!program) {
                const auto plan = program_with(pipeline, {{"moves", moves}}, true, sizes[size]);
                program = std::make_shared<Program>(handles, std::make_shared<const Plan>(plan->plan()));
            }
            return program;
        };
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
        size_t size = 0, most_live = 0;
        bool moves = true;
        uint32_t changes = 0, kept = 0;
        std::unique_ptr<View> view;
        std::vector<float> blended;
        for (uint32_t f = 0; changes < 200; ++f) {
            InFlight& slot = ring[f % 2];
            wait(slot);
            slot.retired.clear();
            const bool change = f > 0 && random() % 2, resize = change && random() % 2;
            if (resize) size = (size + 1 + random() % 3) % 4;
            if (change && !resize) moves = !moves;
            changes += change;
            kept += change && !resize;
            if (change || f == 0) {
                auto heir =
                    std::make_unique<View>(program_for(size, moves), ViewOptions{.heir_of = view.get()});
                if (view) slot.retired.push_back(std::move(view));
                view = std::move(heir);
            }
            FrameDescription frame = description(f);
            frame.size = frame.prev_size = {sizes[size].width, sizes[size].height};
            slot.recorder.record([&](VkCommandBuffer cmd) { view->record(cmd, frame, {}); });
            EXPECT_EQ(view->reset().reason, f == 0   ? Reset::Reason::first_frame
                                            : resize ? Reset::Reason::not_handed_on
                                                     : Reset::Reason::none)
                << f;
            if (resize || f == 0) blended.assign(size_t{sizes[size].width} * sizes[size].height, 0.0f);
            for (size_t i = 0; i < blended.size(); ++i)
                blended[i] = static_cast<float>(i + f) + 0.5f * blended[i];
            VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
            submit.commandBufferCount = 1;
            submit.pCommandBuffers = &slot.recorder.cmd;
            const VkFence fence = slot.fence.get();
            check(vkResetFences(gpu().get(), 1, &fence), "vkResetFences", "");
            check(vkQueueSubmit(gpu().queue(), 1, &submit, fence), "vkQueueSubmit", "");
            most_live = std::max(most_live, allocator.live.size());
            if (f % 7) continue;
            wait(slot);
            ASSERT_EQ(floats(view->captured("blended")), blended) << "frame " << f << ", change " << changes;
        }
        for (const InFlight& slot : ring) wait(slot);
        EXPECT_GT(kept, 50u);
        EXPECT_LT(most_live, 100u);  // three views and eight programs, not two hundred
    }
    EXPECT_TRUE(allocator.live.empty());
    for (const char* name :
         {"vkDeviceWaitIdle", "vkQueueWaitIdle", "vkWaitForFences", "vkQueueSubmit", "vkQueueSubmit2"})
        EXPECT_FALSE(Spy::asked.contains(name)) << name;
}

// --- What a host asks -------------------------------------------------------------------------------------

// Three frames in flight: when frame f is recorded, the counters of frame f - 3 are there, and nobody waited.
TEST_F(EmbeddingGpu, StatisticsOfCompletedFramesCostNoWaiting) {
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
TEST_F(EmbeddingGpu, APipelineCacheGoesOutAndComesIn) {
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

TEST_F(EmbeddingGpu, RequirementsSayWhatAndWhy) {
    const CheckedPipeline pipeline = shadow_pipeline_file("shadows");
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
    EXPECT_EQ(need_of(query, "rayQuery")->why, "trace refine");

    Plan huge = *plan;
    huge.resources.front().extent = {1u << 20, 1};
    const auto missing = unmet(huge, handles_of(gpu()));
    ASSERT_EQ(missing.size(), 1u);
    EXPECT_EQ(missing[0].name, "maxImageDimension2D");
    EXPECT_EQ(missing[0].why, huge.resources.front().names.front());
}

TEST_F(EmbeddingGpu, SlotsSayWhatTheHostMayBring) {
    const CheckedPipeline pipeline = shadow_pipeline_file("shadows");
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

// Whatever the host gets wrong is its own mistake, in a place, and never Vulkan's.
TEST_F(EmbeddingGpu, AHostsMistakesAreItsOwn) {
    const CheckedPipeline pipeline = checked(given_and_history);
    const auto plan = plan_of(pipeline, capturing(pipeline));
    const auto usage = [](auto&& function, const std::string& place, const std::string& text) {
        const auto error = attempt(function);
        ASSERT_TRUE(error) << place;
        EXPECT_EQ(error->code, ErrorCode::usage) << to_string(*error);
        EXPECT_EQ(error->result, VK_SUCCESS);
        EXPECT_EQ(error->place, place);
        EXPECT_NE(error->text.find(text), std::string::npos) << error->text;
    };
    DeviceHandles none = handles_of(gpu());
    none.device = VK_NULL_HANDLE;
    usage([&] { Program(none, plan); }, "DeviceHandles::device", "null");
    none = handles_of(gpu());
    none.get_instance_proc_addr = nullptr;
    usage([&] { Program(none, plan); }, "DeviceHandles::get_instance_proc_addr", "null");
    none = handles_of(gpu());
    none.get_instance_proc_addr = +[](VkInstance instance, const char* name) -> PFN_vkVoidFunction {
        return std::strcmp(name, "vkGetPhysicalDeviceProperties") ? vkGetInstanceProcAddr(instance, name)
                                                                  : nullptr;
    };
    usage([&] { Program(none, plan); }, "vkGetPhysicalDeviceProperties", "does not give it");
    none = handles_of(gpu());
    none.queue_family = 99;
    usage([&] { View(std::make_shared<Program>(none, plan), {}); }, "DeviceHandles::queue_family", "99");
    none = handles_of(gpu());
    none.memory.allocate = [](const MemoryRequest&, MemoryBlock&) { return VK_SUCCESS; };
    usage([&] { Program(none, plan); }, "DeviceHandles::memory", "one of its two");

    const auto program = std::make_shared<Program>(handles_of(gpu()), plan);
    usage([&] { View(program, {.frames_in_flight = 0}); }, "ViewOptions::frames_in_flight", "0");
    usage([&] { View(program, {.poison = 0}); }, "ViewOptions::poison", "compiled with");
    View view(program, {});
    Externals externals(*plan);
    usage([&] { externals["givn"]; }, "p", "did you mean \"given\"?");
    usage([&] { view.output("nothing"); }, "\"nothing\"", "no such output");
    usage([&] { view.captured("given"); }, "\"given\"", "does not capture");
    gpu().run([&](VkCommandBuffer cmd) {
        usage([&] { view.record(cmd, description(0), externals); }, "the slot \"given\"", "nothing is bound");
        FrameDescription wrong = description(0);
        wrong.size = {3, 3};
        usage([&] { view.record(cmd, wrong, externals); }, "p", "3x3");
        usage([&] { view.record_pass(cmd, 0); }, "p", "in order");
        usage([&] { view.end(cmd); }, "p", "behind begin()");
        externals["given"].image = reinterpret_cast<VkImageView>(1);  // is never looked at
        externals["given"].handover = Handover{};
        usage([&] { view.record(cmd, description(0), externals); }, "the slot \"given\"", "Handover::image");
    });
    usage([&] { view.record(VK_NULL_HANDLE, description(0), externals); }, "p", "command buffer");
}

// A host node sees what it is bound to, its parameter as this view has it, and whose view it is.
TEST_F(EmbeddingGpu, AHostNodeIsGivenItsSlotsAndParameters) {
    NodeSet set;
    for (const std::string& name : toy_set().names()) set.add(*toy_set().find(name));
    NodeEntry engine;
    engine.type = parse_toy(R"({ "node": "engine", "doc": "d", "host": true,
      "inputs": { "given": { "kind": "image", "format": "r32f" }, "value": { "kind": "image", "format": "r32f" } },
      "outputs": { "drawn": { "kind": "image", "format": "r32f" } },
      "params": { "gain": { "type": "float", "default": 2, "doc": "d" }, "on": { "type": "bool", "default": true, "doc": "d" } } })",
                            "engine");
    struct Seen {
        float gain = 0;
        const SlotBinding* slot = nullptr;
        VkImage value = VK_NULL_HANDLE;
    };
    engine.callback = [](const HostPassContext& context) {
        auto& seen = *static_cast<Seen*>(context.user);
        seen.gain = std::get<float>(context.param("gain").value());
        seen.slot = context.slot("given");
        seen.value = context.resource("value")->image;
        EXPECT_TRUE(std::get<bool>(context.param("on").value()));
        EXPECT_FALSE(context.param("nosuch"));
        EXPECT_EQ(context.slot("value"), nullptr);
        EXPECT_EQ(context.resource("given"), nullptr);
        VkClearColorValue colour{};
        colour.float32[0] = seen.gain;
        constexpr VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        vkCmdClearColorImage(context.cmd, context.resource("drawn")->image, VK_IMAGE_LAYOUT_GENERAL, &colour,
                             1, &all);
    };
    set.add(std::move(engine));
    const CheckedPipeline pipeline =
        checked(R"("inputs": { "given": { "format": "r32f" } }, "outputs": ["drawn"],
        "nodes": { "fill": { "type": "toy_fill" }, "engine": { "type": "engine" } })",
                set);
    const auto program = std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline)));
    Seen seen[2];
    View views[2] = {View(program, {.user = &seen[0]}), View(program, {.user = &seen[1]})};
    ASSERT_TRUE(views[1].set_param("engine", "gain", ParamValue(5.0f)));
    GpuImage given = image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_SAMPLED_BIT);
    const std::vector<float> zeros(width * height);
    upload_image(gpu(), given, std::as_bytes(std::span(zeros)));
    Externals externals(program->plan());
    externals["given"].image = given.view.get();
    gpu().run([&](VkCommandBuffer cmd) {
        for (View& view : views) view.record(cmd, description(0), externals);
    });
    for (int v = 0; v < 2; ++v) {
        EXPECT_EQ(seen[v].gain, v ? 5.0f : 2.0f);
        EXPECT_EQ(floats(views[v].captured("drawn"))[3], seen[v].gain);
        EXPECT_NE(seen[v].value, VK_NULL_HANDLE);
        ASSERT_TRUE(seen[v].slot);
    }
}

// A raster pass inside the graph: what it draws into is an image of the graph's, read by the next pass.
TEST_F(EmbeddingGpu, AHostNodeDrawsIntoAnImageOfTheGraph) {
    NodeSet set;
    for (const std::string& name : toy_set().names()) set.add(*toy_set().find(name));
    NodeEntry engine;
    engine.type = parse_toy(R"({ "node": "engine", "doc": "d", "host": true, "inputs": {},
      "outputs": { "drawn": { "kind": "image", "format": "r32f" } } })",
                            "engine");
    engine.callback = [](const HostPassContext& context) {
        VkRenderingAttachmentInfo attachment{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
        attachment.imageView = context.resource("drawn")->view;
        attachment.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
        attachment.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
        attachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        attachment.clearValue.color.float32[0] = static_cast<float>(context.frame->frame_index + 3);
        VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
        info.renderArea.extent = {width, height};
        info.layerCount = 1;
        info.colorAttachmentCount = 1;
        info.pColorAttachments = &attachment;
        vkCmdBeginRendering(context.cmd, &info);
        // A part of it again, as a draw would.
        VkClearAttachment again{VK_IMAGE_ASPECT_COLOR_BIT, 0, {}};
        again.clearValue.color.float32[0] = 50;
        const VkClearRect corner{{{0, 0}, {5, 5}}, 0, 1};
        vkCmdClearAttachments(context.cmd, 1, &again, 1, &corner);
        vkCmdEndRendering(context.cmd);
    };
    set.add(std::move(engine));
    const CheckedPipeline pipeline =
        checked(R"("outputs": ["blended"], "nodes": { "engine": { "type": "engine" },
        "blend": { "type": "toy_blend", "in": { "value": "drawn", "history": "blended@-1" } } })",
                set);
    View view(std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline))), {});
    float corner = 0, rest = 0;
    for (uint32_t f = 0; f < 3; ++f) {
        gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(f), {}); });
        corner = 50 + corner / 2;
        rest = static_cast<float>(f + 3) + rest / 2;
        const std::vector<float> blended = floats(view.captured("blended"));
        EXPECT_EQ(blended[2], corner) << f;
        EXPECT_EQ(blended[width * 7 + 9], rest) << f;
    }
}

}  // namespace
}  // namespace penumbra::test
