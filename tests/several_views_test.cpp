// SPDX-License-Identifier: MIT
// Several views and graphs on one device: what they share, and threads that record them at once.
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include "penumbra/user_nodes.h"
#include "tests/embedding_host.h"
#include "tests/test_folder.h"

namespace penumbra::test {
namespace {

class SeveralViewsGpu : public GpuTest {};

GpuImage filled_image() {
    GpuImage image = image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_SAMPLED_BIT);
    const std::vector<float> zeros(width * height);
    upload_image(gpu(), image, std::as_bytes(std::span(zeros)));
    return image;
}

// Four views take turns in one piece of shared memory, each with a past of its own.
TEST_F(SeveralViewsGpu, ViewsThatTakeTurnsShareTransientsAndKeepTheirPasts) {
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

// What another view did in the memory is over before anything of a frame begins: also of images in it that
// this plan knows nothing of, which no validation layer sees.
TEST_F(SeveralViewsGpu, AFrameInSharedMemoryWaitsForAllThatWasBefore) {
    const CheckedPipeline pipeline = checked(given_and_history);
    const auto program =
        std::make_shared<Program>(Spy::handles(), plan_of(pipeline, capturing(pipeline, true)));
    const GpuImage given = filled_image();
    for (const bool shared : {false, true}) {
        View view(program, {.transients = shared ? program->make_transients() : nullptr});
        Externals externals(view.plan());
        externals["given"].image = given.view.get();
        for (uint32_t f = 0; f < 2; ++f) {
            Spy::barriers.clear();
            gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(f), externals); });
        }
        const auto whole = std::ranges::count_if(Spy::barriers, [](const VkMemoryBarrier2& b) {
            constexpr VkAccessFlags2 any = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
            return b.srcStageMask == VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT && b.srcAccessMask == any &&
                   b.dstStageMask == VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT && b.dstAccessMask == any;
        });
        EXPECT_EQ(whole, shared);
    }
}

// Of another pipeline, which has other heaps, and of the same one for smaller frames, which has smaller ones.
TEST_F(SeveralViewsGpu, TransientsOfASmallerPlanAreRefused) {
    const CheckedPipeline other = checked(given_and_history), large = toy_pipeline_file();
    Diagnostics diagnostics;
    const auto small =
        compile(large, {.extent = {width / 2, height / 2}, .device = device_table(handles_of(gpu()))},
                capturing(large, true), diagnostics);
    ASSERT_TRUE(small) << diagnostics.text();
    const auto program = std::make_shared<Program>(handles_of(gpu()), plan_of(large, capturing(large, true)));
    for (const auto& plan : {plan_of(other, capturing(other, true)), std::make_shared<const Plan>(*small)}) {
        const auto of_small = Program(handles_of(gpu()), plan).make_transients();
        const auto error = attempt([&] { View view(program, {.transients = of_small}); });
        ASSERT_TRUE(error);
        EXPECT_EQ(error->code, ErrorCode::usage);
        EXPECT_EQ(error->place, "ViewOptions::transients");
    }
}

// Each of them has needs of its own; together they are what the largest of each heap takes.
TEST_F(SeveralViewsGpu, PlansOfDifferentPipelinesShareTransients) {
    const CheckedPipeline other = checked(given_and_history), toy = toy_pipeline_file();
    const auto one = std::make_shared<Program>(handles_of(gpu()), plan_of(other, capturing(other, true))),
               two = std::make_shared<Program>(handles_of(gpu()), plan_of(toy, capturing(toy, true)));
    const std::array<const Program*, 2> both{one.get(), two.get()};
    const auto transients = make_transients(both);
    EXPECT_GE(bytes_of(*transients),
              std::max(one->plan().memory.shared_bytes, two->plan().memory.shared_bytes));
    EXPECT_LE(bytes_of(*transients), one->plan().memory.shared_bytes + two->plan().memory.shared_bytes);
    EXPECT_NO_THROW(View(one, {.transients = transients}));
    EXPECT_NO_THROW(View(two, {.transients = transients}));
    const std::array<const Program*, 1> null{};
    for (const auto wrong : {std::span<const Program* const>(null), std::span<const Program* const>()}) {
        const auto error = attempt([&] { make_transients(wrong); });
        ASSERT_TRUE(error);
        EXPECT_EQ(error->code, ErrorCode::usage);
    }
}

// A node that reads a table.
NodeSet set_with_table() {
    static const TestFolder folder;  // shaders are compiled when a plan wants them
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

// Two graphs, of one of them two views, on three threads; their frames are submitted in either order, also
// the first ones, which both carry the upload of the tables.
TEST_F(SeveralViewsGpu, ThreadsRecordViewsAndGraphsAtOnce) {
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

// Commands that are recorded and never run, the first of a view or later ones: with a reset behind them the
// frames are those of a new view. Validation would see a table that nobody has uploaded, and images without a
// layout.
TEST_F(SeveralViewsGpu, CommandsThatAreThrownAwayTakeNothingWithThem) {
    const CheckedPipeline pipeline = checked(
        R"("outputs": ["blended"], "nodes": { "table": { "type": "toy_table" },
           "blend": { "type": "toy_blend", "in": { "history": "blended@-1" } } })",
        set_with_table());
    const auto plan = plan_of(pipeline, capturing(pipeline));
    ASSERT_FALSE(plan->tables.empty());
    const auto program = [&] { return std::make_shared<const Program>(handles_of(gpu()), plan); };
    const auto frames = [](View& view) {
        std::vector<Outputs> outputs;
        for (uint32_t f = 0; f < 3; ++f) {
            FrameDescription frame = description(f);
            if (f == 0) frame.flags |= frame_reset;
            gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, frame, {}); });
            outputs.push_back(outputs_of(view));
        }
        return outputs;
    };
    View undisturbed(program(), {});
    const std::vector<Outputs> expected = frames(undisturbed);
    EXPECT_NE(expected[0], expected[1]) << "no history";
    Recorder never_run;
    for (const uint32_t before : {0u, 1u, 2u}) {
        View view(program(), {});
        for (uint32_t f = 0; f < before; ++f)
            gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(f), {}); });
        never_run.record([&](VkCommandBuffer cmd) { view.record(cmd, description(before), {}); });
        EXPECT_EQ(frames(view), expected) << before << " frames before";
    }
}

// Their queries are never read: those were not reset, or are an older frame's.
TEST_F(SeveralViewsGpu, OfCommandsThatAreThrownAwayNothingIsSaid) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    const auto program = std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline)));
    constexpr bool runs[] = {false, true, true, true, false, false, true, true, true};
    Recorder never_run;
    for (const uint32_t n : {1u, 2u}) {
        View view(program, {.frames_in_flight = n});
        std::optional<uint64_t> expected;
        for (uint32_t f = 0; f < std::size(runs); ++f) {
            FrameDescription frame = description(f);
            if (f > 0 && !runs[f - 1]) frame.flags |= frame_reset;
            const auto record = [&](VkCommandBuffer cmd) { view.record(cmd, frame, {}); };
            if (runs[f])
                gpu().run(record);
            else
                never_run.record(record);
            for (const PassStatistics& pass : view.statistics()) {
                EXPECT_EQ(pass.ms.has_value(), runs[f] && gpu().caps().timestamps) << f;
                for (const uint32_t counter : pass.counters)
                    EXPECT_EQ(counter > 0, runs[f]) << f << ", " << n << " in flight";
            }
            if (f >= n && runs[f - n]) expected = f - n;
            const FrameStatistics* completed = view.completed();
            ASSERT_EQ(completed != nullptr, expected.has_value()) << f << ", " << n << " in flight";
            if (!completed) continue;
            EXPECT_EQ(completed->frame, *expected) << f << ", " << n << " in flight";
            EXPECT_EQ(completed->passes[0].ms.has_value(), gpu().caps().timestamps) << f;
        }
    }
}

TEST_F(SeveralViewsGpu, TablesMayBeUploadedAheadOfAllViews) {
    const CheckedPipeline pipeline =
        checked(R"("outputs": ["value"], "nodes": { "table": { "type": "toy_table" } })", set_with_table());
    const auto program = std::make_shared<Program>(Spy::handles(), plan_of(pipeline, capturing(pipeline)));
    EXPECT_GT(program->bytes(), 0u);
    const auto uploads_of = [](auto&& record) {
        Spy::uploads = 0;
        gpu().run(record);
        return Spy::uploads;
    };
    EXPECT_EQ(uploads_of([&](VkCommandBuffer cmd) { program->record_uploads(cmd); }), 1u);
    View view(program, {.tables_uploaded = true}), another(program, {});
    EXPECT_EQ(uploads_of([&](VkCommandBuffer cmd) { view.record(cmd, description(0), {}); }), 0u);
    EXPECT_EQ(floats(view.captured("value"))[2], 4.0f);
    for (uint32_t f = 0; f < 3; ++f)  // with its first frame, and no more
        EXPECT_EQ(uploads_of([&](VkCommandBuffer cmd) { another.record(cmd, description(f), {}); }), f == 0)
            << f;
}

}  // namespace
}  // namespace penumbra::test
