// SPDX-License-Identifier: MIT
// Frames through penumbra.h: everything that a host in C says of them reaches the shader, the view or the
// plan.
#include <cstring>
#include <filesystem>
#include <fstream>

#include "tests/c_requests.h"
#include "tests/embedding_host.h"
#include "tests/test_folder.h"

namespace penumbra::test {
namespace {

// What the frame's block and its slots hold, by column; a history of two more in each frame, in column 7.
const char* const declaration = R"({ "node": "c_frame", "doc": "d", "shader": "c_frame.comp",
    "inputs": { "numbers": { "kind": "buffer", "element": "u32" },
                "given": { "kind": "image", "format": "r32f", "optional": true },
                "history": { "kind": "image", "format": "r32f", "as": "storage", "previous": true } },
    "outputs": { "drawn": { "kind": "image", "format": "r32f" } },
    "dispatch": { "over": "frame", "group": [8, 8] } })";
const char* const shader = R"(#include "node.glsl"
#include "common/pixels.glsl"
void for_pixel(ivec2 p) {
    const bool anew = (frame.flags & FRAME_RESET) != 0u;
    float v[8] = float[](float(numbers[0]), float(numbers.length()), HAS_GIVEN ? texelFetch(given, p, 0).x : -1.0,
                         float(frame.frame_index), frame.prev_jitter.x, frame.jitter.y, frame.dt_s,
                         anew ? 1.0 : 1.0 + 0.5 * imageLoad(history, p).x);
    imageStore(drawn, p, vec4(v[p.x & 7]));
}
void main() { for_each_pixel(); }
)";
const char* const twice = R"({ "node": "c_again", "doc": "d", "shader": "c_again.comp",
    "inputs": { "drawn": { "kind": "image", "format": "r32f" } },
    "outputs": { "doubled": { "kind": "image", "format": "r32f" } },
    "dispatch": { "over": "frame", "group": [8, 8] } })";
const char* const twice_shader = R"(#include "node.glsl"
#include "common/pixels.glsl"
void for_pixel(ivec2 p) { imageStore(doubled, p, 2.0 * texelFetch(drawn, p, 0)); }
void main() { for_each_pixel(); }
)";
const char* const text = R"({ "penumbra": 1, "name": "c",
    "inputs": { "numbers": {}, "given": { "format": "r32f", "optional": true } }, "outputs": ["doubled"],
    "nodes": { "frame": { "type": "c_frame", "in": { "history": "doubled@-1" } }, "again": { "type": "c_again" } } })";

const char* const table = R"({ "node": "c_table", "doc": "d", "shader": "c_table.comp", "inputs": {},
    "outputs": { "value": { "kind": "image", "format": "r32f" } },
    "tables": { "steps": { "file": "steps.bin", "format": "r32f", "extent": [4, 1] } },
    "dispatch": { "over": "frame", "group": [8, 8] } })";
const char* const table_shader = R"(#include "node.glsl"
#include "common/pixels.glsl"
void for_pixel(ivec2 p) { imageStore(value, p, texelFetch(steps, ivec2(p.x & 3, 0), 0)); }
void main() { for_each_pixel(); }
)";
const char* const table_text =
    R"({ "penumbra": 1, "name": "c", "outputs": ["value"], "nodes": { "table": { "type": "c_table" } } })";
constexpr float steps[] = {3, 1, 4, 1.5f};

// Blocks that begin somewhere in the host's memory.
VkResult allocate(void*, const penumbra_memory_request* request, penumbra_memory_block* block) {
    block->offset = 1 << 16;
    uint32_t type = 0;
    while (!(request->need.memoryTypeBits >> type & 1) ||
           (gpu().memory().memoryTypes[type].propertyFlags & request->properties) != request->properties)
        ++type;
    const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr,
                                    block->offset + request->need.size, type};
    const VkResult result = vkAllocateMemory(gpu().get(), &info, nullptr, &block->memory);
    if (result != VK_SUCCESS || !request->mapped) return result;
    return vkMapMemory(gpu().get(), block->memory, block->offset, VK_WHOLE_SIZE, 0, &block->mapped);
}
void release(void*, const penumbra_memory_block* block) {
    vkFreeMemory(gpu().get(), block->memory, nullptr);
}

class CFramesGpu : public GpuTest {
  protected:
    CFramesGpu() : device_(c_device()), error_(sized<penumbra_error>()) {
        device_.allocate = allocate;
        device_.release = release;
        std::ofstream(folder_ / "c_frame.json") << declaration;
        std::ofstream(folder_ / "c_frame.comp") << shader;
        std::ofstream(folder_ / "c_again.json") << twice;
        std::ofstream(folder_ / "c_again.comp") << twice_shader;
        std::ofstream(folder_ / "c_table.json") << table;
        std::ofstream(folder_ / "c_table.comp") << table_shader;
        std::ofstream(folder_ / "steps.bin", std::ios::binary)
            .write(reinterpret_cast<const char*>(steps), sizeof steps);
        EXPECT_EQ(penumbra_nodes_create(&nodes_, &error_), PENUMBRA_OK);
        EXPECT_EQ(penumbra_nodes_add_folder(nodes_, folder_.string().c_str(), "", &error_), PENUMBRA_OK)
            << error_.text;
        request_ = sized<penumbra_plan_request>();
        request_.width = width;
        request_.height = height;
        request_.file = "c.json";
        request_.text = text;
        request_.device = &device_;
        request_.nodes = nodes_;
        request_.captures = &output_;
        request_.capture_count = 1;
        request_.share_transients = request_.hand_on_history = VK_TRUE;
        request_.jitters = PENUMBRA_JITTERS_ALWAYS;
        given_ = sized<penumbra_external>();
        given_.name = "given";
        given_.layout = VK_IMAGE_LAYOUT_GENERAL;
        image_ = image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_SAMPLED_BIT);
        given_.image = image_.view.get();
        numbers_ = sized<penumbra_external>();
        numbers_.name = "numbers";
        buffer_ = make_host_buffer(gpu(), 1024, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "numbers");
        for (uint32_t i = 0; i < 256; ++i) static_cast<uint32_t*>(buffer_.mapped)[i] = i;
        numbers_.buffer = buffer_.get();
    }
    ~CFramesGpu() override { penumbra_nodes_destroy(nodes_); }

    penumbra_plan* plan() {
        penumbra_plan* made = nullptr;
        EXPECT_EQ(penumbra_plan_create(&request_, &made, &error_), PENUMBRA_OK) << error_.text;
        return made;
    }
    penumbra_code record(penumbra_view* view, uint32_t index,
                         std::initializer_list<penumbra_external> externals) {
        frame_ = sized<penumbra_frame>();
        frame_.size[0] = width;
        frame_.size[1] = height;
        frame_.index = index;
        frame_.flags = flags_;
        frame_.dt_s = 0.25f;
        frame_.jitter[1] = 0.125;
        frame_.prev_jitter[0] = 0.0625;
        look(frame_);
        penumbra_code code = PENUMBRA_INTERNAL;
        gpu().run([&](VkCommandBuffer cmd) {
            VkImageMemoryBarrier2 fresh{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
            fresh.srcStageMask = fresh.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
            fresh.dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
            fresh.newLayout = VK_IMAGE_LAYOUT_GENERAL;
            fresh.image = image_.get();
            fresh.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
            VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
            dependency.imageMemoryBarrierCount = 1;
            dependency.pImageMemoryBarriers = &fresh;
            vkCmdPipelineBarrier2(cmd, &dependency);
            const VkClearColorValue colour{.float32 = {17}};
            vkCmdClearColorImage(cmd, image_.get(), VK_IMAGE_LAYOUT_GENERAL, &colour, 1,
                                 &fresh.subresourceRange);
            fresh.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
            fresh.dstAccessMask = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
            fresh.oldLayout = VK_IMAGE_LAYOUT_GENERAL;
            vkCmdPipelineBarrier2(cmd, &dependency);
            code = in_parts_ ? record_in_parts(view, cmd, externals)
                             : penumbra_view_record(view, cmd, &frame_, externals.begin(),
                                                    uint32_t(externals.size()), &error_);
        });
        return code;
    }
    penumbra_code record_in_parts(penumbra_view* view, VkCommandBuffer cmd,
                                  std::initializer_list<penumbra_external> externals) {
        if (const penumbra_code code = penumbra_view_begin(view, cmd, &frame_, externals.begin(),
                                                           uint32_t(externals.size()), &error_))
            return code;
        EXPECT_EQ(penumbra_view_end(view, cmd, &error_), PENUMBRA_USAGE) << "no pass has been recorded";
        for (uint32_t pass = 0; pass < passes_; ++pass)
            if (const penumbra_code code = penumbra_view_record_pass(view, cmd, pass, &error_)) return code;
        return penumbra_view_end(view, cmd, &error_);
    }
    std::vector<float> row(penumbra_view* view) {
        const void* data = nullptr;
        size_t size = 0;
        EXPECT_EQ(penumbra_view_captured(view, "doubled", &data, &size, &error_), PENUMBRA_OK) << error_.text;
        std::vector<float> values(8);
        std::memcpy(values.data(), data, 32);
        for (float& v : values) v /= 2;
        return values;
    }

    const TestFolder folder_;
    penumbra_device device_;
    penumbra_error error_;
    penumbra_nodes* nodes_ = nullptr;
    penumbra_plan_request request_;
    penumbra_frame frame_;
    uint32_t flags_ = 0;
    uint32_t passes_ = 0;
    bool in_parts_ = false;
    const char* output_ = "doubled";
    GpuImage image_;
    GpuBuffer buffer_;
    penumbra_external given_, numbers_;
};

TEST_F(CFramesGpu, WhatAHostSaysOfAFrameReachesIt) {
    penumbra_plan* made = plan();
    penumbra_memory memory = sized<penumbra_memory>();
    ASSERT_EQ(penumbra_plan_memory(made, &memory, &error_), PENUMBRA_OK);
    EXPECT_GT(memory.shared_bytes, 0u);
    penumbra_program* program = nullptr;
    ASSERT_EQ(penumbra_program_create(&device_, made, nullptr, &program, &error_), PENUMBRA_OK)
        << error_.text;
    penumbra_transients* transients = nullptr;
    ASSERT_EQ(penumbra_transients_create(program, &transients, &error_), PENUMBRA_OK) << error_.text;
    penumbra_view_options options = sized<penumbra_view_options>();
    options.frames_in_flight = 3;
    options.no_timestamps = VK_TRUE;
    penumbra_view *view = nullptr, *own = nullptr, *heir = nullptr;
    ASSERT_EQ(penumbra_view_create(program, &options, &own, &error_), PENUMBRA_OK) << error_.text;
    options.transients = transients;
    ASSERT_EQ(penumbra_view_create(program, &options, &view, &error_), PENUMBRA_OK) << error_.text;
    EXPECT_EQ(penumbra_view_bytes(view) + penumbra_transients_bytes(transients), penumbra_view_bytes(own));
    penumbra_view_destroy(own);

    penumbra_external part = numbers_;
    part.offset = 256;
    part.range = 12;
    uint64_t completed = 0;
    uint32_t passes = 0;
    passes_ = penumbra_plan_pass_count(made);
    for (uint32_t f = 0; f < 4; ++f) {
        in_parts_ = f == 2;
        ASSERT_EQ(record(view, 40 + f, {f % 2 ? numbers_ : part, given_}), PENUMBRA_OK) << error_.text;
        const float kept = static_cast<float>(f + 1);
        EXPECT_EQ(row(view),
                  (std::vector<float>{f % 2 ? 0.0f : 64.0f, f % 2 ? 256.0f : 3.0f, 17.0f,
                                      40.0f + static_cast<float>(f), 0.0625f, 0.125f, 0.25f, kept}))
            << f;
        EXPECT_STREQ(penumbra_view_reset_reason(view, nullptr), f ? "none" : "first_frame");
        EXPECT_FALSE(penumbra_view_settled(view)) << "what it keeps never settles";
        ASSERT_EQ(penumbra_view_completed(view, &completed, &passes, nullptr, &error_), PENUMBRA_OK);
        EXPECT_EQ(completed, f < 3 ? UINT64_MAX : 0u) << f;
    }
    EXPECT_EQ(record(view, 44, {numbers_, given_, numbers_}), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.place, ("externals of \"" + std::string(numbers_.name) + "\"").c_str());
    EXPECT_STREQ(error_.text, "stands there twice");
    ASSERT_GT(passes, 1u);
    std::vector<penumbra_pass_statistics> list(passes);
    completed = 99;
    EXPECT_EQ(penumbra_view_completed(view, &completed, &passes, list.data(), &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.place, "passes.struct_size");
    list[0].struct_size = sizeof list[0];  // of all
    passes = 1;
    EXPECT_EQ(penumbra_view_completed(view, &completed, &passes, list.data(), &error_), PENUMBRA_USAGE);
    EXPECT_EQ(completed, 99u) << "nothing is written where something is wrong";
    passes = uint32_t(list.size());
    ASSERT_EQ(penumbra_view_completed(view, &completed, &passes, list.data(), &error_), PENUMBRA_OK);
    EXPECT_EQ(completed, 0u);
    EXPECT_STREQ(list[0].node, "frame");
    EXPECT_STREQ(list[1].node, "again");
    EXPECT_LT(list[0].ms, 0) << "there are no timestamps";

    // What the last frame had is not this frame's.
    EXPECT_EQ(record(view, 44, {given_}), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.place, "the slot \"numbers\"");

    options.heir_of = view;
    ASSERT_EQ(penumbra_view_create(program, &options, &heir, &error_), PENUMBRA_OK) << error_.text;
    ASSERT_EQ(record(heir, 44, {numbers_, given_}), PENUMBRA_OK) << error_.text;
    EXPECT_STREQ(penumbra_view_reset_reason(heir, nullptr), "none");
    EXPECT_EQ(row(heir)[7], 5.0f);
    flags_ = PENUMBRA_FRAME_RESET;
    ASSERT_EQ(record(heir, 45, {numbers_, given_}), PENUMBRA_OK) << error_.text;
    EXPECT_STREQ(penumbra_view_reset_reason(heir, nullptr), "asked");
    EXPECT_EQ(row(heir)[7], 1.0f);
    penumbra_view_destroy(heir);
    penumbra_view_destroy(view);
    penumbra_transients_destroy(transients);
    penumbra_program_destroy(program);
    penumbra_plan_destroy(made);
}

// The second one needs more, whichever is named first.
TEST_F(CFramesGpu, PlansOfDifferentSizesShareTransients) {
    penumbra_plan* plans[2];
    penumbra_program* programs[2]{};
    penumbra_memory needs[] = {sized<penumbra_memory>(), sized<penumbra_memory>()};
    for (size_t i = 0; i < 2; ++i) {
        plans[i] = plan();
        ASSERT_EQ(penumbra_plan_memory(plans[i], &needs[i], &error_), PENUMBRA_OK) << error_.text;
        ASSERT_EQ(penumbra_program_create(&device_, plans[i], nullptr, &programs[i], &error_), PENUMBRA_OK)
            << error_.text;
        request_.width = request_.height = 512;
    }
    ASSERT_LT(needs[0].shared_bytes, needs[1].shared_bytes);
    for (size_t first = 0; first < 2; ++first) {
        const penumbra_program* const both[] = {programs[first], programs[1 - first]};
        penumbra_view_options options = sized<penumbra_view_options>();
        penumbra_transients* transients = nullptr;
        ASSERT_EQ(penumbra_transients_create_for(both, 2, &transients, &error_), PENUMBRA_OK) << error_.text;
        EXPECT_GE(penumbra_transients_bytes(transients), needs[1].shared_bytes);
        options.transients = transients;
        for (const penumbra_program* program : both) {
            penumbra_view* view = nullptr;
            EXPECT_EQ(penumbra_view_create(program, &options, &view, &error_), PENUMBRA_OK) << error_.text;
            penumbra_view_destroy(view);
        }
        penumbra_transients_destroy(transients);
        EXPECT_EQ(penumbra_transients_create_for(both, 0, &transients, &error_), PENUMBRA_USAGE);
        EXPECT_EQ(transients, nullptr);
    }
    penumbra_transients* none = nullptr;
    EXPECT_EQ(penumbra_transients_create_for(nullptr, 2, &none, &error_), PENUMBRA_USAGE);
    for (size_t i = 0; i < 2; ++i) {
        penumbra_program_destroy(programs[i]);
        penumbra_plan_destroy(plans[i]);
    }
}

TEST_F(CFramesGpu, TablesMayBeUploadedAheadOfAllViews) {
    Spy::uploads = 0;
    device_.get_instance_proc_addr = Spy::of_instance;
    request_.text = table_text;
    output_ = "value";
    penumbra_plan* made = plan();
    penumbra_program* program = nullptr;
    ASSERT_EQ(penumbra_program_create(&device_, made, nullptr, &program, &error_), PENUMBRA_OK)
        << error_.text;
    gpu().run([&](VkCommandBuffer cmd) {
        EXPECT_EQ(penumbra_program_record_uploads(nullptr, cmd), PENUMBRA_USAGE);
        EXPECT_EQ(penumbra_program_record_uploads(program, VK_NULL_HANDLE), PENUMBRA_USAGE);
        EXPECT_EQ(Spy::uploads, 0u);
        EXPECT_EQ(penumbra_program_record_uploads(program, cmd), PENUMBRA_OK);
    });
    EXPECT_EQ(Spy::uploads, 1u);
    penumbra_view_options options = sized<penumbra_view_options>();
    options.tables_uploaded = VK_TRUE;
    penumbra_view* view = nullptr;
    ASSERT_EQ(penumbra_view_create(program, &options, &view, &error_), PENUMBRA_OK) << error_.text;
    ASSERT_EQ(record(view, 0, {}), PENUMBRA_OK) << error_.text;
    EXPECT_EQ(Spy::uploads, 1u);
    const void* data = nullptr;
    size_t size = 0;
    ASSERT_EQ(penumbra_view_captured(view, output_, &data, &size, &error_), PENUMBRA_OK) << error_.text;
    ASSERT_GE(size, sizeof steps);
    EXPECT_EQ(std::memcmp(data, steps, sizeof steps), 0);
    penumbra_view_destroy(view);
    penumbra_program_destroy(program);
    penumbra_plan_destroy(made);
}

TEST_F(CFramesGpu, AMemberSleepsAndWakes) {
    request_.text =
        R"({ "penumbra": 1, "name": "c", "outputs": ["value"], "instances": { "lamp": { "of": "lamps" } },
        "nodes": { "table": { "type": "c_table", "instances": "lamps" } } })";
    output_ = "value_lamp";
    penumbra_plan* made = plan();
    penumbra_program* program = nullptr;
    penumbra_view* view = nullptr;
    ASSERT_EQ(penumbra_program_create(&device_, made, nullptr, &program, &error_), PENUMBRA_OK)
        << error_.text;
    ASSERT_EQ(penumbra_view_create(program, nullptr, &view, &error_), PENUMBRA_OK) << error_.text;
    for (uint32_t frame = 0; frame < 3; ++frame) {
        const bool awake = frame != 1;
        ASSERT_EQ(penumbra_view_set_awake(view, "lamp", awake, &error_), PENUMBRA_OK) << error_.text;
        ASSERT_EQ(record(view, frame, {}), PENUMBRA_OK) << error_.text;
        const void* data = nullptr;
        size_t size = 0;
        ASSERT_EQ(penumbra_view_captured(view, output_, &data, &size, &error_), PENUMBRA_OK) << error_.text;
        EXPECT_EQ(*static_cast<const float*>(data), awake ? steps[0] : 0) << frame;
    }
    penumbra_view_destroy(view);
    penumbra_program_destroy(program);
    penumbra_plan_destroy(made);
}

TEST_F(CFramesGpu, WhatAHostAsksOfAPlanIsInIt) {
    penumbra_plan* whole = plan();
    EXPECT_EQ(penumbra_plan_slot_count(whole), 2u);
    penumbra_input input = sized<penumbra_input>();
    input.name = "given";
    input.left_out = VK_TRUE;
    request_.inputs = &input;
    request_.input_count = 1;
    penumbra_plan* without = plan();
    EXPECT_EQ(penumbra_plan_slot_count(without), 1u);
    penumbra_plan_destroy(without);
    request_.input_count = 0;
    request_.text =
        R"({ "penumbra": 1, "name": "c", "inputs": { "drawn": { "format": "r32f" } }, "outputs": ["doubled"],
        "nodes": { "again": { "type": "c_again" } } })";
    request_.host_images = &output_;
    request_.host_image_count = 1;
    penumbra_plan* lent = plan();
    ASSERT_EQ(penumbra_plan_slot_count(lent), 2u);
    uint32_t outputs = 0;
    for (uint32_t i = 0; i < 2; ++i) {
        penumbra_slot slot = sized<penumbra_slot>();
        ASSERT_EQ(penumbra_plan_slot(lent, i, &slot, &error_), PENUMBRA_OK);
        outputs += slot.output;
    }
    EXPECT_EQ(outputs, 1u);
    penumbra_plan_destroy(lent);

    // The same, and what else is done with an output.
    request_.host_image_count = 0;
    penumbra_output_use use = sized<penumbra_output_use>();
    use.name = "doubled";
    use.host_image = VK_TRUE;
    request_.output_uses = &use;
    request_.output_use_count = 1;
    lent = plan();
    EXPECT_EQ(penumbra_plan_slot_count(lent), 2u);
    penumbra_plan_destroy(lent);
    use.host_image = VK_FALSE;
    use.stages = VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
    use.access = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
    lent = plan();
    ASSERT_EQ(penumbra_plan_output_count(lent), 1u);
    penumbra_slot output = sized<penumbra_slot>();
    ASSERT_EQ(penumbra_plan_output(lent, 0, &output, &error_), PENUMBRA_OK) << error_.text;
    EXPECT_STREQ(output.name, "doubled");
    EXPECT_EQ(output.kind, PENUMBRA_IMAGE);
    EXPECT_EQ(output.format, VK_FORMAT_R32_SFLOAT);
    EXPECT_EQ(output.width, width);
    EXPECT_EQ(output.height, height);
    EXPECT_EQ(output.layers, 1u);
    EXPECT_TRUE(output.output);
    EXPECT_EQ(output.stages, use.stages);
    EXPECT_EQ(output.access, use.access);
    EXPECT_EQ(penumbra_plan_output(lent, 1, &output, &error_), PENUMBRA_USAGE);
    penumbra_plan_destroy(lent);
    use.name = "nosuch";
    penumbra_plan* none = nullptr;
    EXPECT_EQ(penumbra_plan_create(&request_, &none, &error_), PENUMBRA_PIPELINE);
    penumbra_plan_destroy(whole);
}

}  // namespace
}  // namespace penumbra::test
