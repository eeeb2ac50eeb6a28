// SPDX-License-Identifier: MIT
// What a host hands over and gets back: images in its layouts, from its queues, outputs in images of its own,
// names for its debugger.
#include "tests/embedding_host.h"

namespace penumbra::test {
namespace {

class HostImagesGpu : public GpuTest {};

TEST_F(HostImagesGpu, AnotherQueuesImageIsAcquiredAndReleased) {
    const CheckedPipeline pipeline = checked(given_and_history);
    const auto program = std::make_shared<Program>(Spy::handles(), plan_of(pipeline, capturing(pipeline)));
    EXPECT_TRUE(Spy::asked.contains("vkCmdDispatch"));
    View view(program, {});
    const GpuImage given = image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_SAMPLED_BIT);
    const uint32_t own = gpu().queue_family(), theirs = VK_QUEUE_FAMILY_EXTERNAL;
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
    EXPECT_EQ(acquire.srcStageMask,
              VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT);  // which a semaphore's wait reaches
    EXPECT_EQ(acquire.srcAccessMask, VK_ACCESS_2_NONE);
    EXPECT_EQ(acquire.dstStageMask, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT);
    EXPECT_EQ(acquire.image, given.get());
    EXPECT_EQ(release.srcQueueFamilyIndex, own);
    EXPECT_EQ(release.dstQueueFamilyIndex, theirs);
    EXPECT_EQ(release.oldLayout, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    EXPECT_EQ(release.newLayout, VK_IMAGE_LAYOUT_GENERAL);
    EXPECT_EQ(release.srcStageMask, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT);
    EXPECT_EQ(release.dstStageMask, VK_PIPELINE_STAGE_2_NONE);  // the acquisition's, over there
    EXPECT_EQ(release.dstAccessMask, VK_ACCESS_2_NONE);
}

TEST_F(HostImagesGpu, DebuggersAreToldTheNames) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    Spy::names.clear();
    Spy::labels.clear();
    View view(std::make_shared<Program>(Spy::handles(), plan_of(pipeline, {})), {});
    for (const char* name : {"blended@0", "blended@1", "scattered", "list", "chain", "the frame block"})
        EXPECT_TRUE(Spy::names.contains(name)) << name;
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(0), {}); });
    for (const PlanPass& pass : view.plan().passes) EXPECT_TRUE(Spy::labels.contains(pass.node)) << pass.node;

    // A layer gives the functions to who has not enabled the extension, too, and objects to each call.
    DeviceHandles unnamed = Spy::handles();
    unnamed.debug_utils = false;
    Spy::names.clear();
    Spy::labels.clear();
    run_toys(unnamed, 1);
    EXPECT_TRUE(Spy::names.empty() && Spy::labels.empty());
}

// What a host does with an image of its own: fills it, which was never used before, ...
void clear(VkCommandBuffer cmd, const GpuImage& image, VkImageLayout layout, float value) {
    constexpr VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    VkImageMemoryBarrier2 fresh{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    fresh.dstStageMask = VK_PIPELINE_STAGE_2_CLEAR_BIT;
    fresh.dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
    fresh.newLayout = layout;
    fresh.image = image.get();
    fresh.subresourceRange = all;
    VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    dependency.imageMemoryBarrierCount = 1;
    dependency.pImageMemoryBarriers = &fresh;
    vkCmdPipelineBarrier2(cmd, &dependency);
    VkClearColorValue colour{};
    colour.float32[0] = value;
    vkCmdClearColorImage(cmd, image.get(), layout, &colour, 1, &all);
}

// ... and copies it out.
void copy_out(VkCommandBuffer cmd, const GpuImage& image, const GpuBuffer& to) {
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {width, height, 1};
    vkCmdCopyImageToBuffer(cmd, image.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.get(), 1, &region);
}

// The host clears an image and copies out of it, in the layouts of those commands; in between the frame reads
// it. Nothing but the handover orders the three, and synchronisation validation listens.
TEST_F(HostImagesGpu, AnImageComesAndGoesInTheHostsLayouts) {
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
            clear(cmd, given, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, static_cast<float>(f + 1));
            view.record(cmd, description(f), externals);
            copy_out(cmd, given, copy);
        });
        expected = static_cast<float>(f + 1) + expected / 2;
        EXPECT_EQ(floats(view.captured("blended")), std::vector<float>(width * height, expected)) << f;
        EXPECT_EQ(static_cast<const float*>(copy.mapped)[7], static_cast<float>(f + 1));
    }
}

// The host orders all with barriers of its own into the frame's stages and out of them, and has said no
// stages. The layouts change all the same, between its accesses and the frame's.
TEST_F(HostImagesGpu, AHostsOwnBarriersOrderTheChangesOfLayout) {
    const CheckedPipeline pipeline =
        checked(R"("inputs": { "given": { "format": "r32f" } }, "outputs": ["blended"],
        "nodes": { "blend": { "type": "toy_blend", "in": { "value": "given", "history": null } } })");
    View view(std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline))), {});
    const GpuImage given =
        image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    const GpuBuffer copy =
        make_host_buffer(gpu(), 4 * width * height, VK_BUFFER_USAGE_TRANSFER_DST_BIT, "copy");
    const Use& use = view.plan().slots[*view.plan().slot("given")].use;
    Externals externals(view.plan());
    externals["given"] = {.image = given.view.get(),
                          .handover = Handover{.image = given.get(),
                                               .layout_before = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                               .layout_after = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL}};
    const auto order = [](VkCommandBuffer cmd, VkPipelineStageFlags2 from, VkAccessFlags2 made,
                          VkPipelineStageFlags2 to, VkAccessFlags2 read) {
        VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2, nullptr, from, made, to, read};
        VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
        dependency.memoryBarrierCount = 1;
        dependency.pMemoryBarriers = &barrier;
        vkCmdPipelineBarrier2(cmd, &dependency);
    };
    gpu().run([&](VkCommandBuffer cmd) {
        clear(cmd, given, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 3);
        order(cmd, VK_PIPELINE_STAGE_2_CLEAR_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, use.stages, use.access);
        view.record(cmd, description(0), externals);
        order(cmd, use.stages, use.access, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
        copy_out(cmd, given, copy);
    });
    EXPECT_EQ(floats(view.captured("blended")), std::vector<float>(width * height, 3));
    EXPECT_EQ(static_cast<const float*>(copy.mapped)[7], 3.0f);
}

// Of a buffer that fills two slots, as of a sun that stands still, the host has one half of each transfer.
TEST_F(HostImagesGpu, ABufferInTwoSlotsIsAcquiredAndReleasedOnce) {
    const CheckedPipeline pipeline = checked(
        R"("inputs": { "a": { "kind": "buffer" }, "b": { "kind": "buffer" } }, "outputs": ["first", "second"],
        "nodes": { "fill": { "type": "toy_fill" }, "list": { "type": "toy_list" },
                   "one": { "type": "toy_scatter", "in": { "list": "a" }, "out": { "scattered": "first" } },
                   "two": { "type": "toy_scatter", "in": { "list": "b" }, "out": { "scattered": "second" } } })");
    View view(std::make_shared<Program>(Spy::handles(), plan_of(pipeline, {})), {});
    constexpr size_t bytes = 8 * width * height;
    const GpuBuffer list = make_host_buffer(gpu(), bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "list");
    std::memset(list.mapped, 0, bytes);
    Externals externals(view.plan());
    for (const char* slot : {"a", "b"})
        externals[slot] = {.buffer = list.get(),
                           .handover = Handover{.family_before = VK_QUEUE_FAMILY_EXTERNAL,
                                                .family_after = VK_QUEUE_FAMILY_EXTERNAL}};
    Spy::buffers.clear();
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(0), externals); });
    ASSERT_EQ(Spy::buffers.size(), 2u);
    EXPECT_EQ(Spy::buffers[0].srcQueueFamilyIndex, VK_QUEUE_FAMILY_EXTERNAL);
    EXPECT_EQ(Spy::buffers[1].dstQueueFamilyIndex, VK_QUEUE_FAMILY_EXTERNAL);
    externals["b"].handover->family_after = VK_QUEUE_FAMILY_IGNORED;
    gpu().run(
        [&](VkCommandBuffer cmd) { EXPECT_THROW(view.record(cmd, description(1), externals), Failure); });
}

// On a first frame what a host has for a previous value is this frame's: one image in two slots, of which no
// layout changes twice.
TEST_F(HostImagesGpu, AnImageInTwoSlotsIsHandedOverOnce) {
    const CheckedPipeline pipeline = checked(
        R"("inputs": { "given": { "format": "r32f", "history": "host" } }, "outputs": ["now", "before"],
            "nodes": {
                "now": { "type": "toy_blend", "in": { "value": "given" }, "out": { "blended": "now" } },
                "before": { "type": "toy_blend", "in": { "value": "given@-1" }, "out": { "blended": "before" } } })");
    View view(std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline))), {});
    const GpuImage given =
        image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    Externals externals(view.plan());
    SlotBinding& now = externals["given"];
    now = {.image = given.view.get(),
           .handover = Handover{.image = given.get(),
                                .stages_before = VK_PIPELINE_STAGE_2_CLEAR_BIT,
                                .access_before = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                .layout_before = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                .layout_after = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL}};
    externals["given@-1"] = now;
    gpu().run([&](VkCommandBuffer cmd) {
        clear(cmd, given, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 2);
        view.record(cmd, description(0), externals);
    });
    for (const char* const output : {"now", "before"})
        EXPECT_EQ(floats(view.captured(output)), std::vector<float>(width * height, 2)) << output;
    externals["given@-1"].handover->layout_after = VK_IMAGE_LAYOUT_GENERAL;
    gpu().run(
        [&](VkCommandBuffer cmd) { EXPECT_THROW(view.record(cmd, description(1), externals), Failure); });
}

// What a frame writes it does not read through another slot: the write begins by forgetting what was there.
TEST_F(HostImagesGpu, AnOutputsImageIsNoInput) {
    const CheckedPipeline pipeline =
        checked(R"("inputs": { "given": { "format": "r32f" } }, "outputs": ["blended"],
        "nodes": { "blend": { "type": "toy_blend", "in": { "value": "given", "history": null } } })");
    CompileOptions options;
    options.outputs["blended"].host_image = true;
    View view(std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, options)), {});
    const GpuImage own =
        image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT);
    Externals externals(view.plan());
    for (const char* slot : {"given", "blended"})
        externals[slot] = {.image = own.view.get(), .handover = Handover{.image = own.get()}};
    gpu().run(
        [&](VkCommandBuffer cmd) { EXPECT_THROW(view.record(cmd, description(0), externals), Failure); });
    externals["given"].handover.reset();  // the view tells
    gpu().run(
        [&](VkCommandBuffer cmd) { EXPECT_THROW(view.record(cmd, description(0), externals), Failure); });
}

// The host's own image need not be larger than the frame, whatever the plan allows.
TEST_F(HostImagesGpu, AnOutputsImageOfTheFramesSizeIsCaptured) {
    CompileOptions options =
        capturing(checked(R"("outputs": ["value"], "nodes": { "fill": { "type": "toy_fill" } })"));
    const CheckedPipeline pipeline =
        checked(R"("outputs": ["value"], "nodes": { "fill": { "type": "toy_fill" } })");
    options.outputs["value"].host_image = true;
    Target target;
    target.extent = {2 * width, 2 * height};
    target.device = device_table(handles_of(gpu()));
    Diagnostics diagnostics;
    auto plan = compile(pipeline, target, options, diagnostics);
    ASSERT_TRUE(plan) << diagnostics.text();
    View view(std::make_shared<Program>(handles_of(gpu()), std::make_shared<const Plan>(std::move(*plan))),
              {});
    const GpuImage own =
        image_of(VK_FORMAT_R32_SFLOAT,
                 VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    Externals externals(view.plan());
    externals["value"] = {.image = own.view.get(), .handover = Handover{.image = own.get()}};
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(3), externals); });
    const std::vector<float> captured = floats(view.captured("value"));
    ASSERT_EQ(captured.size(), 4u * width * height);
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            EXPECT_EQ(captured[2 * width * y + x], static_cast<float>(width * y + x + 3)) << x << " " << y;
}

// "value" is put into images of the host, another one every frame, is read on within the frame, and goes back
// in the layout of a copy's source.
TEST_F(HostImagesGpu, AnOutputIsPutIntoTheHostsImage) {
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
        EXPECT_EQ(view.output("value").layout, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        EXPECT_EQ(view.output("blended").layout, VK_IMAGE_LAYOUT_GENERAL);
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

// What the host did with its image before, writing or reading, is over when the frame begins to write: one
// command buffer has a clear, a frame, a copy out of the image, and another frame.
TEST_F(HostImagesGpu, AnOutputsImageWaitsForWhatTheHostDidWithIt) {
    // A node without counters, whose clearing would order more than is asked for.
    const CheckedPipeline pipeline =
        checked(R"("inputs": { "given": { "format": "r32f" } }, "outputs": ["blended"],
        "nodes": { "blend": { "type": "toy_blend", "in": { "value": "given", "history": null } } })");
    CompileOptions options;
    options.outputs["blended"].host_image = true;
    View view(std::make_shared<Program>(Spy::handles(), plan_of(pipeline, options)), {});
    const GpuImage own =
        image_of(VK_FORMAT_R32_SFLOAT,
                 VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    const GpuBuffer copy =
        make_host_buffer(gpu(), 4 * width * height, VK_BUFFER_USAGE_TRANSFER_DST_BIT, "copy");
    GpuImage given = image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_SAMPLED_BIT);
    const std::vector<float> sevens(width * height, 7.0f);
    upload_image(gpu(), given, std::as_bytes(std::span(sevens)));
    Externals externals(view.plan());
    externals["given"].image = given.view.get();
    gpu().run([&](VkCommandBuffer cmd) {
        clear(cmd, own, VK_IMAGE_LAYOUT_GENERAL, 0);
        externals["blended"] = {.image = own.view.get(),
                                .handover = Handover{.image = own.get(),
                                                     .stages_before = VK_PIPELINE_STAGE_2_CLEAR_BIT,
                                                     .stages_after = VK_PIPELINE_STAGE_2_COPY_BIT,
                                                     .access_before = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                                     .access_after = VK_ACCESS_2_TRANSFER_READ_BIT,
                                                     .layout_after = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL}};
        view.record(cmd, description(0), externals);
        copy_out(cmd, own, copy);
        externals["blended"].handover->stages_before = VK_PIPELINE_STAGE_2_COPY_BIT;
        externals["blended"].handover->access_before = VK_ACCESS_2_TRANSFER_READ_BIT;
        view.record(cmd, description(1), externals);
    });
    EXPECT_EQ(static_cast<const float*>(copy.mapped)[7], 7.0f);
    // Of reads validation does not notice it.
    std::vector<VkPipelineStageFlags2> waited_for;
    for (const VkImageMemoryBarrier2& barrier : Spy::images)
        if (barrier.image == own.get() && barrier.newLayout == VK_IMAGE_LAYOUT_GENERAL)
            waited_for.push_back(barrier.srcStageMask);
    ASSERT_EQ(waited_for.size(), 2u);
    EXPECT_TRUE(waited_for[0] & VK_PIPELINE_STAGE_2_CLEAR_BIT);
    EXPECT_TRUE(waited_for[1] & VK_PIPELINE_STAGE_2_COPY_BIT);
}

// What another queue did is ordered by a semaphore, and its stages may be none of this queue's; of what the
// image held nothing is acquired.
TEST_F(HostImagesGpu, AnOutputsImageOfAnotherQueueIsReleasedAlone) {
    const CheckedPipeline pipeline =
        checked(R"("outputs": ["value"], "nodes": { "fill": { "type": "toy_fill" } })");
    CompileOptions options;
    options.outputs["value"].host_image = true;
    View view(std::make_shared<Program>(Spy::handles(), plan_of(pipeline, options)), {});
    const GpuImage image =
        image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT);
    const uint32_t own = gpu().queue_family(), theirs = VK_QUEUE_FAMILY_EXTERNAL;
    Externals externals(view.plan());
    externals["value"] = {.image = image.view.get(),
                          .handover = Handover{.image = image.get(),
                                               .stages_before = VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
                                               .access_before = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                               .layout_after = VK_IMAGE_LAYOUT_GENERAL,
                                               .family_before = theirs,
                                               .family_after = theirs}};
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(0), externals); });
    size_t transitions = 0;
    for (const VkImageMemoryBarrier2& barrier : Spy::images) {
        if (barrier.image != image.get() || barrier.oldLayout != VK_IMAGE_LAYOUT_UNDEFINED) continue;
        ++transitions;
        EXPECT_FALSE(barrier.srcStageMask & VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT);
        EXPECT_FALSE(barrier.srcAccessMask & VK_ACCESS_2_TRANSFER_WRITE_BIT);
        EXPECT_EQ(barrier.srcQueueFamilyIndex, VK_QUEUE_FAMILY_IGNORED);
    }
    EXPECT_EQ(transitions, 1u);
    ASSERT_EQ(Spy::transfers.size(), 1u);
    EXPECT_EQ(Spy::transfers[0].srcQueueFamilyIndex, own);
    EXPECT_EQ(Spy::transfers[0].dstQueueFamilyIndex, theirs);
}

// A frame that was begun and never ended has put nothing into its image.
TEST_F(HostImagesGpu, AnOutputIsTheImageOfTheLastFrameThatWasRecorded) {
    const CheckedPipeline pipeline =
        checked(R"("outputs": ["value"], "nodes": { "fill": { "type": "toy_fill" } })");
    CompileOptions options;
    options.outputs["value"].host_image = true;
    View view(std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, options)), {});
    constexpr VkImageUsageFlags usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    const GpuImage recorded = image_of(VK_FORMAT_R32_SFLOAT, usage),
                   begun = image_of(VK_FORMAT_R32_SFLOAT, usage);
    Externals externals(view.plan());
    const auto bind = [&](const GpuImage& image) {
        externals["value"] = {.image = image.view.get(), .handover = Handover{.image = image.get()}};
    };
    bind(recorded);
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(0), externals); });
    bind(begun);
    Recorder never_run;
    never_run.record([&](VkCommandBuffer cmd) { view.begin(cmd, description(1), externals); });
    EXPECT_EQ(view.output("value").image, recorded.get());
}

TEST_F(HostImagesGpu, AnOutputWithAPastStaysPenumbras) {
    const CheckedPipeline pipeline = checked(given_and_history);
    CompileOptions options;
    options.outputs["blended"].host_image = true;
    Diagnostics diagnostics;
    EXPECT_FALSE(
        compile(pipeline, {.extent = {width, height}, .device = reference_device()}, options, diagnostics));
    EXPECT_NE(diagnostics.text().find("the next frame reads its previous value"), std::string::npos);
}

}  // namespace
}  // namespace penumbra::test
