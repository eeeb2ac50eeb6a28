// SPDX-License-Identifier: MIT
// penumbra.h: errors are values, structs are read by their sizes, nothing throws. That frames come out right
// is examples/minimal_c's to show (tests/install_test.sh).
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "penumbra/graph.h"
#include "tests/allocations.h"
#include "tests/c_nodes.h"
#include "tests/c_requests.h"
#include "tests/test_folder.h"

namespace penumbra::test {
namespace {

class CApiGpu : public CGpuTest {};

TEST_F(CApiGpu, APipelinesMistakesHaveTheirPlace) {
    const penumbra_plan_request request = request_of(
        "{ \"penumbra\": 1,\n  \"name\": \"c\", \"nodes\": { \"g\": { \"type\": \"gides\" } }, \"outputs\": "
        "[\"x\"] }");
    EXPECT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_PIPELINE);
    EXPECT_EQ(plan_, nullptr);
    EXPECT_EQ(std::string(error_.place).substr(0, 9), "c.json:2:") << error_.place;
    EXPECT_NE(std::strstr(error_.text, "did you mean \"guides\"?"), nullptr) << error_.text;
    penumbra_plan_request none = request_of(nullptr);
    none.file = "nosuch.json";
    EXPECT_EQ(penumbra_plan_create(&none, &plan_, &error_), PENUMBRA_PIPELINE);
}

// What is longer than an error's room is cut, and what was there before leaves nothing behind.
TEST_F(CApiGpu, TextsAreCutToTheirRoom) {
    std::string many = "{ \"penumbra\": 1, \"name\": \"c\", \"outputs\": [\"x\"], \"nodes\": {";
    for (int i = 0; i < 200; ++i)
        many += (i ? ", \"node" : " \"node") + std::to_string(i) + "\": { \"type\": \"nosuch\" }";
    const penumbra_plan_request request = request_of((many += "} }").c_str());
    struct {
        penumbra_error error;
        char behind[16];
    } own{sized<penumbra_error>(), "untouched"};
    EXPECT_EQ(penumbra_plan_create(&request, &plan_, &own.error), PENUMBRA_PIPELINE);
    EXPECT_EQ(std::strlen(own.error.text), sizeof own.error.text - 1);
    EXPECT_STREQ(own.behind, "untouched");
    EXPECT_EQ(penumbra_plan_create(nullptr, &plan_, &own.error), PENUMBRA_USAGE);
    EXPECT_STREQ(own.error.place, "request");
    EXPECT_STREQ(own.error.text, "is null");
}

// A newer caller's structs are longer; one that says nothing is wrong.
TEST_F(CApiGpu, StructsAreReadByTheirSizes) {
    struct Newer {
        penumbra_plan_request request;
        uint64_t more[4];
    } newer{request_of(c_pipeline), {1, 2, 3, 4}};
    newer.request.struct_size = sizeof newer;
    EXPECT_EQ(penumbra_plan_create(&newer.request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    penumbra_plan* other = nullptr;
    penumbra_plan_request unset = request_of(c_pipeline);
    unset.struct_size = 0;
    EXPECT_EQ(penumbra_plan_create(&unset, &other, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.place, "request.struct_size");
    struct NewerSlot {
        penumbra_slot slot;
        uint64_t more;
    } slots[2]{};
    slots[0].slot.struct_size = sizeof slots[0];
    slots[0].more = 7;
    EXPECT_EQ(penumbra_plan_slot(plan_, 0, &slots[0].slot, &error_), PENUMBRA_OK);
    EXPECT_EQ(slots[0].slot.struct_size, sizeof slots[0]);
    EXPECT_EQ(slots[0].more, 7u);
    // Elements of an array lie as far apart as the caller's header has them.
    struct NewerFact {
        penumbra_fact fact;
        uint64_t more;
    } facts[2]{{{sizeof(NewerFact), VK_FALSE, "moves"}, 1}, {{sizeof(NewerFact), VK_FALSE, "alhpa"}, 1}};
    penumbra_plan_request request = request_of(c_pipeline);
    request.facts = &facts[0].fact;
    request.fact_count = 2;
    for (const uint32_t second : {uint32_t{sizeof facts[1]}, 0u}) {  // the first one's is all of theirs
        facts[1].fact.struct_size = second;
        EXPECT_EQ(penumbra_plan_create(&request, &other, &error_), PENUMBRA_PIPELINE);
        EXPECT_NE(std::strstr(error_.text, "alhpa"), nullptr) << error_.text;
    }
}

TEST_F(CApiGpu, PipelinesMayAllBeInMemory) {
    penumbra_plan_request request = request_of(nullptr);
    request.file = "packed/mine.json";
    request.read = [](void* base, const char* file) -> const char* {
        if (!std::strcmp(file, "packed/mine.json")) return R"({ "extends": "../base.json", "name": "mine" })";
        return std::strcmp(file, "base.json") ? nullptr : static_cast<const char*>(base);
    };
    request.read_user = const_cast<char*>(c_pipeline);
    EXPECT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    request.file = "mine.json";
    penumbra_plan* none = nullptr;
    EXPECT_EQ(penumbra_plan_create(&request, &none, &error_), PENUMBRA_PIPELINE);
    EXPECT_NE(std::strstr(error_.text, "mine.json: no such file"), nullptr) << error_.text;
}

// Programs of older headers: members that came later are taken as 0, and are not written.
TEST_F(CApiGpu, AnOlderCallersStructsAreShorter) {
    const auto older = []<class T, class M>(T& t, M T::*last) {
        const auto* end = reinterpret_cast<const char*>(&(t.*last)) + sizeof(M);
        t.struct_size = static_cast<uint32_t>(end - reinterpret_cast<const char*>(&t));
        std::memset(reinterpret_cast<char*>(&t) + t.struct_size, 0x7f, sizeof t - t.struct_size);
    };
    penumbra_device device = c_device();
    penumbra_plan_request request = request_of(c_pipeline);
    older(request, &penumbra_plan_request::hand_on_history);
    request.device = &device;
    ASSERT_LT(request.struct_size, sizeof request);
    ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    penumbra_slot slot{};
    older(slot, &penumbra_slot::access);
    ASSERT_EQ(penumbra_plan_slot(plan_, 0, &slot, &error_), PENUMBRA_OK) << error_.text;
    EXPECT_EQ(slot.accepted_count, 0x7f7f7f7fu) << "written behind the end";
    penumbra_program* program = nullptr;
    ASSERT_EQ(penumbra_program_create(&device, plan_, nullptr, &program, &error_), PENUMBRA_OK)
        << error_.text;
    penumbra_view* view = nullptr;
    ASSERT_EQ(penumbra_view_create(program, nullptr, &view, &error_), PENUMBRA_OK) << error_.text;
    penumbra_frame frame{};
    look(frame);
    frame.size[0] = 29;
    frame.size[1] = 13;
    older(frame, &penumbra_frame::flags);
    gpu().run([&](VkCommandBuffer cmd) {
        EXPECT_EQ(penumbra_view_record(view, cmd, &frame, nullptr, 0, &error_), PENUMBRA_USAGE);
        EXPECT_STREQ(error_.place, "the slot \"depth\"") << "the frame itself was read";
    });
    frame.struct_size -= uint32_t{alignof(penumbra_frame)};
    EXPECT_EQ(penumbra_view_record(view, VK_NULL_HANDLE, &frame, nullptr, 0, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.place, "frame.struct_size");
    // Elements that lie so far apart would not be aligned.
    penumbra_input inputs[2]{};
    inputs[0].struct_size = uint32_t{sizeof inputs[0] - alignof(penumbra_input) / 2};
    request.inputs = inputs;
    request.input_count = 2;
    penumbra_plan* none = nullptr;
    EXPECT_EQ(penumbra_plan_create(&request, &none, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.place, "request.inputs.struct_size");
    penumbra_view_destroy(view);
    penumbra_program_destroy(program);
}

TEST_F(CApiGpu, NothingThrowsWhateverIsNull) {
    EXPECT_EQ(penumbra_plan_create(nullptr, nullptr, nullptr), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_plan_create(nullptr, &plan_, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.place, "request");
    EXPECT_EQ(penumbra_plan_slot(nullptr, 0, nullptr, &error_), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_program_create(nullptr, nullptr, nullptr, nullptr, nullptr), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_view_create(nullptr, nullptr, nullptr, nullptr), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_view_record(nullptr, nullptr, nullptr, nullptr, 0, nullptr), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_view_output(nullptr, nullptr, nullptr, nullptr), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_view_captured(nullptr, nullptr, nullptr, nullptr, nullptr), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_view_completed(nullptr, nullptr, nullptr, nullptr, nullptr), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_view_set_param(nullptr, nullptr, nullptr, nullptr, 0, nullptr), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_view_begin(nullptr, nullptr, nullptr, nullptr, 0, nullptr), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_view_record_pass(nullptr, nullptr, 0, nullptr), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_view_end(nullptr, nullptr, nullptr), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_plan_output(nullptr, 0, nullptr, &error_), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_plan_read(nullptr, nullptr, &error_), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_program_record_uploads(nullptr, nullptr), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_plan_extent(nullptr, nullptr, nullptr, nullptr, &error_), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_plan_pass(nullptr, 0, nullptr, &error_), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_plan_param(nullptr, 0, 0, nullptr, &error_), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_view_param(nullptr, nullptr, nullptr, nullptr, nullptr, &error_), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_plan_output_count(nullptr), 0u);
    EXPECT_EQ(penumbra_plan_pass_count(nullptr), 0u);
    EXPECT_EQ(penumbra_plan_slot_count(nullptr), 0u);
    EXPECT_EQ(penumbra_view_bytes(nullptr), 0u);
    EXPECT_FALSE(penumbra_view_settled(nullptr));
    EXPECT_STREQ(penumbra_view_reset_reason(nullptr, nullptr), "none");
    const char* resource = nullptr;
    EXPECT_STREQ(penumbra_view_reset_reason(nullptr, &resource), "none");
    EXPECT_STREQ(resource, "");
    penumbra_plan_destroy(nullptr);
    penumbra_program_destroy(nullptr);
    penumbra_view_destroy(nullptr);
    penumbra_transients_destroy(nullptr);
}

// Wherever the host's own memory ends: also where what is wrong is being put into words.
TEST_F(CApiGpu, NothingThrowsWhereverMemoryEnds) {
    const std::string wrong =
        std::string(c_pipeline).replace(std::string(c_pipeline).rfind("guides"), 6, "gides");
    for (const char* pipeline : {c_pipeline, wrong.c_str()}) {
        const penumbra_plan_request request = request_of(pipeline);
        const penumbra_code whole = pipeline == c_pipeline ? PENUMBRA_OK : PENUMBRA_PIPELINE;
        ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), whole) << error_.text;
        penumbra_plan_destroy(std::exchange(plan_, nullptr));  // the node set is made once
        const size_t before = allocations;
        ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), whole) << error_.text;
        const size_t needed = allocations - before;
        ASSERT_GT(needed, 100u);
        size_t spared = 0;  // std::stable_sort asks for room and does without
        for (size_t n = 1; n <= needed; n += n < 50 || n + 50 > needed ? 1 : 1 + needed / 200) {
            penumbra_plan_destroy(std::exchange(plan_, nullptr));
            failing_allocation = allocations + n;
            const penumbra_code code = penumbra_plan_create(&request, &plan_, &error_);
            failing_allocation = ~size_t{0};
            if (code == whole && spared++ < 3) continue;
            ASSERT_EQ(code, PENUMBRA_OUT_OF_MEMORY) << n << " of " << needed;
            EXPECT_EQ(error_.code, code);
            EXPECT_EQ(error_.result, VK_ERROR_OUT_OF_HOST_MEMORY);
            EXPECT_STREQ(error_.text, "no memory");
            EXPECT_EQ(plan_, nullptr);
        }
        penumbra_plan_destroy(std::exchange(plan_, nullptr));
        EXPECT_EQ(penumbra_plan_create(&request, &plan_, &error_), whole) << "afterwards all is as before";
        penumbra_plan_destroy(std::exchange(plan_, nullptr));
    }
}

struct Counted {
    uint32_t calls = 0, live = 0, fail_at = 0;
};

VkResult allocate(void* user, const penumbra_memory_request* request, penumbra_memory_block* block) {
    auto& counted = *static_cast<Counted*>(user);
    if (++counted.calls == counted.fail_at) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    uint32_t type = 0;
    while (!(request->need.memoryTypeBits >> type & 1) ||
           (gpu().memory().memoryTypes[type].propertyFlags & request->properties) != request->properties)
        ++type;
    const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, request->need.size,
                                    type};
    const VkResult result = vkAllocateMemory(gpu().get(), &info, nullptr, &block->memory);
    if (result != VK_SUCCESS) return result;
    ++counted.live;
    return request->mapped ? vkMapMemory(gpu().get(), block->memory, 0, VK_WHOLE_SIZE, 0, &block->mapped)
                           : VK_SUCCESS;
}

void release(void* user, const penumbra_memory_block* block) {
    --static_cast<Counted*>(user)->live;
    vkFreeMemory(gpu().get(), block->memory, nullptr);
}

TEST_F(CApiGpu, AHostsMistakesAndItsMemoryAreSaidAsTheyAre) {
    Counted counted;
    penumbra_device device = c_device();
    device.allocate = allocate;
    device.release = release;
    device.memory_user = &counted;
    penumbra_plan_request request = request_of(c_pipeline);
    request.device = &device;
    ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    penumbra_program* program = nullptr;
    ASSERT_EQ(penumbra_program_create(&device, plan_, nullptr, &program, &error_), PENUMBRA_OK)
        << error_.text;
    penumbra_view* view = nullptr;
    ASSERT_EQ(penumbra_view_create(program, nullptr, &view, &error_), PENUMBRA_OK) << error_.text;
    EXPECT_GT(penumbra_view_bytes(view), 0u);
    EXPECT_FALSE(penumbra_view_settled(view)) << "there is no frame yet";
    EXPECT_GT(counted.live, 0u);
    size_t size = 0;
    EXPECT_EQ(penumbra_program_pipeline_cache(program, &size, nullptr, &error_), PENUMBRA_OK);
    std::vector<char> cache(size);
    EXPECT_EQ(penumbra_program_pipeline_cache(program, &size, cache.data(), &error_), PENUMBRA_OK);

    penumbra_frame frame{};
    frame.struct_size = sizeof frame;
    look(frame);
    frame.size[0] = 29;
    frame.size[1] = 13;
    gpu().run([&](VkCommandBuffer cmd) {
        EXPECT_EQ(penumbra_view_record(view, cmd, &frame, nullptr, 0, &error_), PENUMBRA_USAGE);
        EXPECT_STREQ(error_.place, "the slot \"depth\"");
        EXPECT_EQ(error_.result, VK_SUCCESS);
        penumbra_external external{};
        external.struct_size = sizeof external;
        external.name = "detph";
        EXPECT_EQ(penumbra_view_record(view, cmd, &frame, &external, 1, &error_), PENUMBRA_USAGE);
        EXPECT_NE(std::strstr(error_.text, "did you mean \"depth\"?"), nullptr) << error_.text;
    });
    const double one = 1;
    EXPECT_EQ(penumbra_view_set_param(view, "guide", "x", &one, 1, &error_), PENUMBRA_USAGE);
    EXPECT_NE(std::strstr(error_.text, "did you mean \"guides\"?"), nullptr) << error_.text;
    EXPECT_EQ(penumbra_view_set_param(view, "guides", "x", &one, 1, &error_), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_view_set_param(view, "guides", nullptr, &one, 1, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.place, "param");
    EXPECT_EQ(penumbra_view_set_awake(view, "lamp", VK_FALSE, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.place, "\"lamp\"");
    EXPECT_EQ(penumbra_view_set_awake(view, nullptr, VK_FALSE, &error_), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_view_set_awake(nullptr, "lamp", VK_FALSE, nullptr), PENUMBRA_USAGE);
    penumbra_output output{};
    output.struct_size = sizeof output;
    EXPECT_EQ(penumbra_view_output(view, "view_depth", &output, &error_), PENUMBRA_OK);
    EXPECT_NE(output.image, VK_NULL_HANDLE);
    uint64_t completed = 0;
    uint32_t passes = 0;
    EXPECT_EQ(penumbra_view_completed(view, &completed, &passes, nullptr, &error_), PENUMBRA_OK);
    EXPECT_EQ(completed, UINT64_MAX);
    EXPECT_EQ(passes, 1u);
    penumbra_view_options heir{};
    heir.struct_size = sizeof heir;
    heir.heir_of = view;
    penumbra_view* next = nullptr;
    EXPECT_EQ(penumbra_view_create(program, &heir, &next, &error_), PENUMBRA_OK) << error_.text;
    penumbra_view_destroy(next);
    penumbra_view_destroy(view);
    penumbra_program_destroy(program);
    EXPECT_EQ(counted.live, 0u);

    counted = {};
    ASSERT_EQ(penumbra_program_create(&device, plan_, nullptr, &program, &error_), PENUMBRA_OK);
    ASSERT_EQ(penumbra_view_create(program, nullptr, &view, &error_), PENUMBRA_OK);
    penumbra_view_destroy(view);
    penumbra_program_destroy(program);
    const uint32_t calls = counted.calls;
    for (uint32_t n = 1; n <= calls; ++n) {
        counted = {0, 0, n};
        program = nullptr;
        view = nullptr;
        penumbra_code code = penumbra_program_create(&device, plan_, nullptr, &program, &error_);
        if (code == PENUMBRA_OK) code = penumbra_view_create(program, nullptr, &view, &error_);
        EXPECT_EQ(code, PENUMBRA_OUT_OF_MEMORY) << n;
        EXPECT_EQ(error_.result, VK_ERROR_OUT_OF_DEVICE_MEMORY);
        EXPECT_EQ(view, nullptr);
        penumbra_program_destroy(program);
        EXPECT_EQ(counted.live, 0u) << n;
    }
}

// Without the validation layer, which takes memory in the same way and may not be without.
TEST_F(CApiGpu, EachAllocationOfAViewMayFail) {
    Device own({});
    penumbra_device device = c_device();
    device.queue_family = own.queue_family();
    device.instance = own.instance();
    device.physical = own.physical();
    device.device = own.get();
    penumbra_plan_request request{};
    request.struct_size = sizeof request;
    request.width = 64;
    request.height = 36;
    request.file = PENUMBRA_SOURCE_DIR "/pipelines/shadows.json";
    request.device = &device;
    ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    penumbra_program* program = nullptr;
    ASSERT_EQ(penumbra_program_create(&device, plan_, nullptr, &program, &error_), PENUMBRA_OK)
        << error_.text;
    const auto view_made = [&] {
        penumbra_view* view = nullptr;
        const penumbra_code code = penumbra_view_create(program, nullptr, &view, &error_);
        EXPECT_EQ(code == PENUMBRA_OK, view != nullptr);
        penumbra_view_destroy(view);
        return code;
    };
    ASSERT_EQ(view_made(), PENUMBRA_OK) << error_.text;
    const long live = live_allocations;
    const size_t before = allocations;
    ASSERT_EQ(view_made(), PENUMBRA_OK) << error_.text;
    const size_t needed = allocations - before;
    EXPECT_EQ(live_allocations, live);
    size_t said = 0;
    for (size_t n = 1; n <= needed; ++n) {
        failing_allocation = allocations + n;
        const penumbra_code code = view_made();
        failing_allocation = ~size_t{0};
        EXPECT_TRUE(code == PENUMBRA_OK || code == PENUMBRA_OUT_OF_MEMORY) << n << ": " << error_.text;
        said += code == PENUMBRA_OUT_OF_MEMORY;
        ASSERT_EQ(live_allocations, live) << n << " of " << needed;
    }
    std::printf("%zu allocations of a view, %zu of them needed\n", needed, said);
    EXPECT_GT(said, 50u);
    EXPECT_EQ(view_made(), PENUMBRA_OK) << error_.text;
    penumbra_program_destroy(program);
}

VkCommandPool c_pool = VK_NULL_HANDLE;
VkCommandBuffer c_commands = VK_NULL_HANDLE;

VkCommandBuffer begin_commands() {
    check(vkResetCommandPool(gpu().get(), c_pool, 0), "vkResetCommandPool", "C");
    const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    check(vkBeginCommandBuffer(c_commands, &begin), "vkBeginCommandBuffer", "C");
    return c_commands;
}

void submit_commands() {
    check(vkEndCommandBuffer(c_commands), "vkEndCommandBuffer", "C");
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &c_commands;
    check(vkQueueSubmit(gpu().queue(), 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit", "C");
    check(vkQueueWaitIdle(gpu().queue()), "vkQueueWaitIdle", "C");
}

// c_nodes.c: a node that a host in C records, and one that is compiled from a folder; frames of several
// sizes.
TEST_F(CApiGpu, NodesOfTheCallers) {
    const TestFolder folder;
    std::ofstream(folder / "c_twice.json") << R"({ "node": "c_twice", "doc": "d", "shader": "c_twice.comp",
        "inputs": { "drawn": { "kind": "image", "format": "r32f" } },
        "outputs": { "doubled": { "kind": "image", "format": "r32f" } },
        "dispatch": { "over": "frame", "group": [8, 8] } })";
    std::ofstream(folder / "c_twice.comp") << R"(#include "node.glsl"
#include "common/pixels.glsl"
void for_pixel(ivec2 p) { imageStore(doubled, p, 2.0 * texelFetch(drawn, p, 0)); }
void main() { for_each_pixel(); }
)";
    const VkCommandPoolCreateInfo create{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr, 0,
                                         gpu().queue_family()};
    check(vkCreateCommandPool(gpu().get(), &create, nullptr, &c_pool), "vkCreateCommandPool", "C");
    const Owned<VkCommandPool> pool(gpu().get(), c_pool);
    const VkCommandBufferAllocateInfo allocate_info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr,
                                                    c_pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    check(vkAllocateCommandBuffers(gpu().get(), &allocate_info, &c_commands), "vkAllocateCommandBuffers",
          "C");
    const std::string at = folder.string();
    c_host host{c_device(), at.c_str(), begin_commands, submit_commands, vkCmdClearColorImage};
    const char* problem = run_c_nodes(&host);
    EXPECT_EQ(problem, nullptr) << (problem ? problem : "");
}

}  // namespace
}  // namespace penumbra::test
