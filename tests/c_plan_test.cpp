// SPDX-License-Identifier: MIT
// Plans through penumbra.h: what they ask of a host is data.
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "penumbra/version.h"
#include "tests/c_requests.h"

namespace penumbra::test {
namespace {

class CPlanGpu : public CGpuTest {
  protected:
    void plan_of(const char* pipeline) {
        const penumbra_plan_request request = request_of(pipeline);
        ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    }
    void expect_twice(const penumbra_plan_request& request, const char* place) {
        EXPECT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_USAGE);
        EXPECT_STREQ(error_.place, place);
        EXPECT_STREQ(error_.text, "stands there twice");
    }
    // The slot or output of a name.
    penumbra_slot slot_of(const char* name) {
        auto slot = sized<penumbra_slot>();
        for (uint32_t i = 0; penumbra_plan_slot(plan_, i, &slot, &error_) == PENUMBRA_OK; ++i)
            if (!std::strcmp(slot.name, name)) return slot;
        for (uint32_t i = 0; penumbra_plan_output(plan_, i, &slot, &error_) == PENUMBRA_OK; ++i)
            if (!std::strcmp(slot.name, name)) return slot;
        ADD_FAILURE() << "no slot " << name;
        return slot;
    }
};

// A driver whose devices say that they have no core feature at all.
VKAPI_ATTR void VKAPI_CALL no_features(VkPhysicalDevice device, VkPhysicalDeviceFeatures2* features) {
    vkGetPhysicalDeviceFeatures2(device, features);
    features->features = {};
}
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_a_lesser_driver(VkInstance instance, const char* name) {
    if (!std::strcmp(name, "vkGetPhysicalDeviceFeatures2"))
        return reinterpret_cast<PFN_vkVoidFunction>(no_features);
    return vkGetInstanceProcAddr(instance, name);
}

TEST_F(CPlanGpu, PlansAndWhatTheyNeedAreData) {
    EXPECT_STREQ(penumbra_version(), PENUMBRA_VERSION_TEXT);
    const penumbra_plan_request request = request_of(c_pipeline);
    ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    ASSERT_EQ(penumbra_plan_slot_count(plan_), 2u);
    auto slot = sized<penumbra_slot>();
    ASSERT_EQ(penumbra_plan_slot(plan_, 0, &slot, &error_), PENUMBRA_OK);
    EXPECT_STREQ(slot.name, "depth");
    EXPECT_EQ(slot.kind, PENUMBRA_IMAGE);
    EXPECT_EQ(slot.width, 29u);
    EXPECT_EQ(slot.struct_size, sizeof slot);
    EXPECT_EQ(penumbra_plan_slot(plan_, 2, &slot, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.text, "the plan has 2 slots");
    EXPECT_GT(penumbra_plan_requirement_count(plan_), 3u);
    auto need = sized<penumbra_requirement>();
    ASSERT_EQ(penumbra_plan_requirement(plan_, 0, &need, nullptr), PENUMBRA_OK);
    EXPECT_STREQ(need.kind, "version");
    EXPECT_EQ(need.value, VK_API_VERSION_1_3);
    auto memory = sized<penumbra_memory>();
    ASSERT_EQ(penumbra_plan_memory(plan_, &memory, &error_), PENUMBRA_OK);
    EXPECT_GT(memory.heap_bytes, 0u);
}

TEST(CPlan, FeaturesAreTurnedOnByName) {
    VkPhysicalDeviceVulkan12Features v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    VkPhysicalDeviceFeatures2 chain{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &v12};
    auto error = sized<penumbra_error>();
    EXPECT_EQ(penumbra_enable_feature("shaderInt8", &chain, &error), PENUMBRA_OK);
    EXPECT_TRUE(v12.shaderInt8 && !v12.shaderFloat16);
    EXPECT_EQ(penumbra_enable_feature("maintenance4", &chain, &error), PENUMBRA_USAGE);
    EXPECT_NE(std::string(error.text).find("maintenance4"), std::string::npos) << error.text;
    EXPECT_EQ(penumbra_enable_feature(nullptr, &chain, &error), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_enable_feature("shaderInt8", nullptr, nullptr), PENUMBRA_USAGE);
}

TEST_F(CPlanGpu, WhatADeviceLacksIsListedWhereThereIsRoom) {
    const penumbra_plan_request request =
        request_of(R"({ "penumbra": 1, "name": "c", "inputs": { "depth": {}, "normal": {} },
        "outputs": ["guide_normal"], "nodes": { "guides": { "type": "guides" } } })");
    ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    penumbra_device device = c_device();
    device.get_instance_proc_addr = of_a_lesser_driver;
    uint32_t count = 0;
    ASSERT_EQ(penumbra_plan_unmet(plan_, &device, &count, nullptr, &error_), PENUMBRA_OK) << error_.text;
    ASSERT_GT(count, 0u);
    const uint32_t all = count;
    std::vector list(all + 1, sized<penumbra_requirement>());
    ASSERT_EQ(penumbra_plan_unmet(plan_, &device, &count, list.data(), &error_), PENUMBRA_OK) << error_.text;
    EXPECT_EQ(count, all);
    for (uint32_t i = 0; i < all; ++i) EXPECT_STREQ(list[i].kind, "feature") << list[i].name;
    EXPECT_EQ(list[all].name, nullptr) << "written behind the end";
    count = all - 1;  // no room for one of them: nothing is written
    list.assign(all, sized<penumbra_requirement>());
    EXPECT_EQ(penumbra_plan_unmet(plan_, &device, &count, list.data(), &error_), PENUMBRA_USAGE);
    EXPECT_EQ(std::string(error_.text), std::to_string(all) + " requirements are not met");
    for (const penumbra_requirement& requirement : list) EXPECT_EQ(requirement.name, nullptr);

    // All have the size of the first, which is looked at before anything is written.
    list.assign(all + 1, penumbra_requirement{});
    count = all + 1;
    EXPECT_EQ(penumbra_plan_unmet(plan_, &device, &count, list.data(), &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.place, "list.struct_size");
    EXPECT_EQ(count, all + 1);
    list[0].struct_size = sizeof list[0];
    ASSERT_EQ(penumbra_plan_unmet(plan_, &device, &count, list.data(), &error_), PENUMBRA_OK) << error_.text;
    EXPECT_EQ(count, all);
    for (uint32_t i = 0; i < all; ++i) EXPECT_STREQ(list[i].kind, "feature") << i;
    EXPECT_EQ(list[all].name, nullptr) << "written behind the end";
}

TEST_F(CPlanGpu, FormatsThatASlotAcceptsAreThoseThatARequestTakes) {
    plan_of(c_pipeline);
    const penumbra_slot depth = slot_of("depth");
    std::vector<std::string> names(depth.accepted, depth.accepted + depth.accepted_count);
    std::ranges::sort(names);
    EXPECT_EQ(names, (std::vector<std::string>{"d32", "r32f"}));
    for (const std::string& name : names) {
        auto input = sized<penumbra_input>();
        input.name = "depth";
        input.format = name.c_str();
        input.width = 29;
        input.height = 13;
        penumbra_plan_request request = request_of(c_pipeline);
        request.inputs = &input;
        request.input_count = 1;
        penumbra_plan_destroy(std::exchange(plan_, nullptr));
        EXPECT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << name << error_.text;
        EXPECT_FALSE(slot_of("depth").layered);
    }
    EXPECT_EQ(depth.usage, VkImageUsageFlags{VK_IMAGE_USAGE_SAMPLED_BIT});
    const penumbra_slot view_depth = slot_of("view_depth");
    EXPECT_EQ(view_depth.accepted_count, 0u) << "the plan's own";
    EXPECT_TRUE(view_depth.usage & VK_IMAGE_USAGE_STORAGE_BIT);
    EXPECT_EQ(view_depth.levels, 1u);
    auto info = sized<penumbra_plan_info>();
    ASSERT_EQ(penumbra_plan_read(plan_, &info, &error_), PENUMBRA_OK);
    EXPECT_TRUE(info.camera);
}

TEST_F(CPlanGpu, MembersAndCountersHaveNames) {
    auto request = request_of(nullptr);
    request.file = PENUMBRA_SOURCE_DIR "/pipelines/lights_shadows.json";
    request.text = nullptr;
    const penumbra_device device = c_device();
    request.device = &device;
    ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    std::set<std::string> members, counters;
    const char* member = nullptr;
    for (uint32_t i = 0; i < penumbra_plan_member_count(plan_); ++i) {
        ASSERT_EQ(penumbra_plan_member(plan_, i, &member, &error_), PENUMBRA_OK);
        members.insert(member);
    }
    EXPECT_FALSE(members.empty());
    EXPECT_EQ(penumbra_plan_member(plan_, static_cast<uint32_t>(members.size()), &member, &error_),
              PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_plan_member(plan_, 0, nullptr, &error_), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_plan_member_count(nullptr), 0u);
    for (uint32_t i = 0; i < penumbra_plan_pass_count(plan_); ++i) {
        auto pass = sized<penumbra_pass>();
        ASSERT_EQ(penumbra_plan_pass(plan_, i, &pass, &error_), PENUMBRA_OK);
        for (uint32_t k = 0; k < pass.counter_count; ++k)
            counters.insert(std::string(pass.type) + "." + pass.counters[k]);
    }
    EXPECT_TRUE(counters.contains("allot.allotted"));
}

TEST_F(CPlanGpu, AnInputIsSpokenOfOnce) {
    penumbra_input twice[2] = {sized<penumbra_input>(), sized<penumbra_input>()};
    twice[0].name = twice[1].name = "normal";
    twice[0].left_out = VK_TRUE;
    twice[1].format = "rgba32f";
    twice[1].width = 29;
    twice[1].height = 13;
    penumbra_plan_request request = request_of(c_pipeline);
    request.inputs = twice;
    request.input_count = 2;
    expect_twice(request, "request.inputs of \"normal\"");
}

TEST_F(CPlanGpu, AFactIsSpokenOfOnce) {
    penumbra_fact twice[2] = {sized<penumbra_fact>(), sized<penumbra_fact>()};
    twice[0].name = twice[1].name = "moves";
    twice[0].holds = VK_TRUE;
    penumbra_plan_request request = request_of(c_pipeline);
    request.facts = twice;
    request.fact_count = 2;
    expect_twice(request, "request.facts of \"moves\"");
}

TEST_F(CPlanGpu, ACaptureThatIsNamedTwiceIsMadeOnce) {
    const char* const captures[] = {"view_depth", "view_depth"};
    penumbra_plan_request request = request_of(c_pipeline);
    request.captures = captures;
    uint32_t passes[2] = {};
    for (const uint32_t count : {1u, 2u}) {
        request.capture_count = count;
        penumbra_plan_destroy(std::exchange(plan_, nullptr));
        ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
        passes[count - 1] = penumbra_plan_pass_count(plan_);
    }
    EXPECT_EQ(passes[1], passes[0]);
}

TEST_F(CPlanGpu, AWrongCaptureIsOfThePipeline) {
    const char* const captures[] = {"view_dept"};
    penumbra_plan_request request = request_of(c_pipeline);
    request.captures = captures;
    request.capture_count = 1;
    EXPECT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_PIPELINE);
    EXPECT_STREQ(error_.place, "c.json");
    EXPECT_NE(std::strstr(error_.text, "did you mean \"view_depth\"?"), nullptr) << error_.text;
}

// What follows the frame, an output of half its size, and what has a size of its own.
TEST_F(CPlanGpu, OfASmallerFrameTheTopLeftPartIsUsed) {
    penumbra_nodes* nodes = nullptr;
    ASSERT_EQ(penumbra_nodes_create(&nodes, &error_), PENUMBRA_OK);
    EXPECT_EQ(penumbra_nodes_add(
                  nodes, R"({ "node": "c_half", "doc": "d", "host": true,
        "inputs": { "given": { "kind": "image", "format": "r32f" }, "own": { "kind": "image", "format": "rgba8" },
                    "words": { "kind": "buffer", "element": "u32" } },
        "outputs": { "small": { "kind": "image", "format": "r16f", "extent": { "of": "frame", "div": [2, 2] } } } })",
                  [](const penumbra_call*) {}, &error_),
              PENUMBRA_OK)
        << error_.text;
    penumbra_plan_request request = request_of(R"({ "penumbra": 1, "name": "c", "outputs": ["small"],
        "inputs": { "given": { "format": "r32f" }, "own": { "format": "rgba8", "extent": [5, 7] }, "words": {} },
        "nodes": { "c_half": { "type": "c_half" } } })");
    request.nodes = nodes;
    EXPECT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    penumbra_nodes_destroy(nodes);
    const uint32_t frame[2] = {19, 10};
    const auto extent_of = [&](const char* name) {
        std::array<uint32_t, 2> extent{};
        EXPECT_EQ(penumbra_plan_extent(plan_, name, frame, extent.data(), &error_), PENUMBRA_OK)
            << error_.text;
        return extent;
    };
    EXPECT_EQ(extent_of("given"), (std::array{19u, 10u}));
    EXPECT_EQ(extent_of("own"), (std::array{5u, 7u}));
    EXPECT_EQ(extent_of("small"), (std::array{10u, 5u}));

    uint32_t extent[2] = {3, 3};
    EXPECT_EQ(penumbra_plan_extent(plan_, "words", frame, extent, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.text, "\"words\" is no image");
    EXPECT_EQ(penumbra_plan_extent(plan_, "samll", frame, extent, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.text, "the plan has no slot or output \"samll\"; did you mean \"small\"?");
    for (const auto& [width, height] : {std::pair{30u, 13u}, {29u, 14u}, {0u, 13u}, {29u, 0u}}) {
        const uint32_t wrong[2] = {width, height};
        EXPECT_EQ(penumbra_plan_extent(plan_, "small", wrong, extent, &error_), PENUMBRA_USAGE);
        EXPECT_STREQ(error_.place, "frame");
    }
    EXPECT_EQ(penumbra_plan_extent(plan_, "small", frame, nullptr, &error_), PENUMBRA_USAGE);
    EXPECT_EQ(extent[0], 3u) << "nothing is written where something is wrong";
}

// What an editor lists, sets and reads.
TEST_F(CPlanGpu, PassesAndTheirParametersAreData) {
    penumbra_nodes* nodes = nullptr;
    ASSERT_EQ(penumbra_nodes_create(&nodes, &error_), PENUMBRA_OK);
    ASSERT_EQ(penumbra_nodes_add(
                  nodes, R"({ "node": "c_params", "doc": "d", "host": true, "inputs": {},
        "outputs": { "drawn": { "kind": "image", "format": "r32f" } },
        "params": { "on": { "type": "bool", "default": true, "doc": "d" },
                    "steps": { "type": "int", "default": -3, "range": [-4, 8], "doc": "how many" },
                    "seed": { "type": "uint", "default": 7, "doc": "d" },
                    "far": { "type": "float", "default": 0.5, "range": [0, 1.5], "unit": "m", "doc": "d" },
                    "near": { "type": "float", "default": 0.05, "range": [0, 0.1], "doc": "d" },
                    "taps": { "type": "uint", "default": 7, "constant": true, "doc": "d" },
                    "tint": { "type": "vec3", "default": [1, 2, 3], "doc": "d" },
                    "way": { "type": "enum", "values": ["up", "down"], "default": "down", "doc": "d" } } })",
                  [](const penumbra_call*) {}, &error_),
              PENUMBRA_OK)
        << error_.text;
    penumbra_plan_request request = request_of(R"({ "penumbra": 1, "name": "c", "outputs": ["drawn"],
        "nodes": { "draw": { "type": "c_params", "params": { "far": 0.25 } } } })");
    const char* const drawn = "drawn";
    const penumbra_device device = c_device();
    request.nodes = nodes;
    request.device = &device;
    request.captures = &drawn;
    request.capture_count = 1;
    EXPECT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    penumbra_nodes_destroy(nodes);
    ASSERT_EQ(penumbra_plan_pass_count(plan_), 2u);
    auto pass = sized<penumbra_pass>();
    ASSERT_EQ(penumbra_plan_pass(plan_, 1, &pass, &error_), PENUMBRA_OK) << error_.text;
    EXPECT_STREQ(pass.node, "drawn");
    EXPECT_STREQ(pass.type, "capture");
    EXPECT_EQ(pass.param_count, 0u);
    ASSERT_EQ(penumbra_plan_pass(plan_, 0, &pass, &error_), PENUMBRA_OK) << error_.text;
    EXPECT_STREQ(pass.node, "draw");
    EXPECT_STREQ(pass.type, "c_params");
    EXPECT_EQ(penumbra_plan_pass(plan_, 2, &pass, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.text, "the plan has 2 passes");

    constexpr double infinite = std::numeric_limits<double>::infinity();
    struct Expected {
        const char* name;
        penumbra_param_type type;
        std::vector<double> initial;
        double least, greatest;
        std::vector<double> other;  // a value to set
    };
    const std::vector<Expected> expected = {
        {"on", PENUMBRA_PARAM_BOOL, {1}, 0, 1, {0}},
        {"steps", PENUMBRA_PARAM_INT, {-3}, -4, 8, {8}},
        {"seed", PENUMBRA_PARAM_UINT, {7}, 0, 4294967295.0, {4294967295.0}},
        {"far", PENUMBRA_PARAM_FLOAT, {0.25}, 0, 1.5, {1.5}},
        {"near", PENUMBRA_PARAM_FLOAT, {0.05f}, 0, 0.1, {0.1f}},
        {"tint", PENUMBRA_PARAM_VEC3, {1, 2, 3}, -infinite, infinite, {-4, 5, 0.5}},
        {"way", PENUMBRA_PARAM_ENUM, {1}, 0, 1, {0}}};
    ASSERT_EQ(pass.param_count, expected.size()) << "the constant one is not there";
    penumbra_program* program = nullptr;
    ASSERT_EQ(penumbra_program_create(&device, plan_, nullptr, &program, &error_), PENUMBRA_OK)
        << error_.text;
    penumbra_view* view = nullptr;
    ASSERT_EQ(penumbra_view_create(program, nullptr, &view, &error_), PENUMBRA_OK) << error_.text;
    const auto value_of = [&](const char* name) {
        double values[4];
        uint32_t count = 4;
        EXPECT_EQ(penumbra_view_param(view, "draw", name, values, &count, &error_), PENUMBRA_OK)
            << error_.text;
        return std::vector<double>(values, values + count);
    };
    auto param = sized<penumbra_param>();
    for (uint32_t i = 0; i < expected.size(); ++i) {
        const Expected& e = expected[i];
        ASSERT_EQ(penumbra_plan_param(plan_, 0, i, &param, &error_), PENUMBRA_OK) << error_.text;
        EXPECT_STREQ(param.name, e.name);
        EXPECT_STREQ(param.unit, i == 3 ? "m" : "");
        EXPECT_STREQ(param.doc, i == 1 ? "how many" : "d");
        EXPECT_EQ(param.type, e.type) << e.name;
        EXPECT_EQ(param.value_count, i == 6 ? 2u : 0u) << e.name;
        ASSERT_EQ(param.count, e.initial.size()) << e.name;
        EXPECT_EQ(std::vector<double>(param.initial, param.initial + param.count), e.initial) << e.name;
        EXPECT_EQ(param.range[0], e.least) << e.name;
        EXPECT_EQ(param.range[1], e.greatest) << e.name;
        EXPECT_EQ(value_of(e.name), e.initial);
        EXPECT_EQ(
            penumbra_view_set_param(view, "draw", e.name, e.other.data(), uint32_t(e.other.size()), &error_),
            PENUMBRA_OK)
            << error_.text;
        EXPECT_EQ(value_of(e.name), e.other);
    }
    EXPECT_STREQ(param.values[0], "up");
    EXPECT_STREQ(param.values[1], "down");
    EXPECT_EQ(penumbra_plan_param(plan_, 0, 7, &param, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.text, "draw has 7 dynamic parameters");
    EXPECT_EQ(penumbra_plan_param(plan_, 2, 0, &param, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.place, "pass");

    // What a value may be is said where it is another one.
    const double wrong[] = {9, std::numeric_limits<double>::quiet_NaN(), 0};
    EXPECT_EQ(penumbra_view_set_param(view, "draw", "steps", wrong, 1, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.place, "draw.steps");
    EXPECT_STREQ(error_.text, "takes -4 to 8");
    EXPECT_EQ(penumbra_view_set_param(view, "draw", "far", wrong, 1, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.text, "takes 0 to 1.5 m");
    EXPECT_EQ(penumbra_view_set_param(view, "draw", "tint", wrong, 3, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.text, "takes finite numbers");
    uint32_t count = 2;
    double values[2];
    EXPECT_EQ(penumbra_view_param(view, "draw", "tint", values, &count, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.text, "tint has 3 numbers");
    EXPECT_EQ(penumbra_view_param(view, "draw", "tint", nullptr, &count, &error_), PENUMBRA_OK);
    EXPECT_EQ(count, 3u);
    EXPECT_EQ(penumbra_view_param(view, "draw", "tnit", nullptr, &count, &error_), PENUMBRA_USAGE);
    EXPECT_NE(std::strstr(error_.text, "did you mean \"tint\"?"), nullptr) << error_.text;
    penumbra_view_destroy(view);
    penumbra_program_destroy(program);
}

TEST_F(CPlanGpu, WhetherToJitterAndWhenToStop) {
    auto info = sized<penumbra_plan_info>();
    plan_of(c_pipeline);
    ASSERT_EQ(penumbra_plan_read(plan_, &info, &error_), PENUMBRA_OK);
    EXPECT_FALSE(info.jitter);
    EXPECT_EQ(info.settles, 0u) << "it has no past";
    penumbra_plan_destroy(std::exchange(plan_, nullptr));
    penumbra_plan_request request = request_of(nullptr);
    request.file = PENUMBRA_SOURCE_DIR "/pipelines/hybrid_shadows.json";
    ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    ASSERT_EQ(penumbra_plan_read(plan_, &info, &error_), PENUMBRA_OK);
    EXPECT_TRUE(info.jitter);
    EXPECT_GT(info.settles, 16u) << "jitter's places";
    EXPECT_NE(info.settles, UINT32_MAX);
    penumbra_plan_destroy(std::exchange(plan_, nullptr));
    request.jitters = PENUMBRA_JITTERS_NEVER;
    ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    ASSERT_EQ(penumbra_plan_read(plan_, &info, &error_), PENUMBRA_OK);
    EXPECT_FALSE(info.jitter);
    penumbra_plan_destroy(std::exchange(plan_, nullptr));
    for (const uint32_t none : {3u, UINT32_MAX}) {
        request.jitters = none;
        EXPECT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_USAGE);
        EXPECT_STREQ(error_.place, "request.jitters");
    }
    request.file = PENUMBRA_SOURCE_DIR "/pipelines/covered.json";  // where nobody asks
    for (const uint32_t jitters : {PENUMBRA_JITTERS_ALWAYS, PENUMBRA_JITTERS_AS_ASKED}) {
        request.jitters = jitters;
        ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
        ASSERT_EQ(penumbra_plan_read(plan_, &info, &error_), PENUMBRA_OK);
        EXPECT_EQ(info.jitter != 0, jitters == PENUMBRA_JITTERS_ALWAYS);
        penumbra_plan_destroy(std::exchange(plan_, nullptr));
    }
    penumbra_plan_destroy(std::exchange(plan_, nullptr));
    request.file = PENUMBRA_SOURCE_DIR "/pipelines/fidelityfx.json";
    ASSERT_EQ(penumbra_plan_create(&request, &plan_, &error_), PENUMBRA_OK) << error_.text;
    ASSERT_EQ(penumbra_plan_read(plan_, &info, &error_), PENUMBRA_OK);
    EXPECT_EQ(info.settles, UINT32_MAX) << "what it keeps never settles";
}

}  // namespace
}  // namespace penumbra::test
