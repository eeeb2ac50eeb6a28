// SPDX-License-Identifier: MIT
// What exceeds a device is refused while there is nothing but the plan, with the limit and by how much;
// images as long and as narrow as a device knows are not.
#include "graph/limits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "graph/shader_compiler.h"
#include "graph/workgroup_memory.h"
#include "penumbra/graph.h"
#include "tests/golden_text.h"
#include "tests/shipped.h"

namespace penumbra::test {
namespace {

// Masks that a still camera's frames keep are more than one buffer of some devices holds where an image is
// larger than 4K: such a host leaves out what they are kept by.
std::string refusal(const CheckedPipeline& pipeline, Extent extent, const DeviceTable& device) {
    Diagnostics diagnostics;
    Target target{.extent = extent, .inputs = told_inputs(pipeline), .device = device};
    const bool large = uint64_t{extent.width} * extent.height > uint64_t{3840} * 2160;
    if (large && pipeline.input("moved_boxes")) target.left_out.insert("moved_boxes");
    const auto plan = compile(pipeline, target, {}, diagnostics);
    EXPECT_EQ(plan.has_value(), diagnostics.size() == 0);
    return diagnostics.text();
}

// Every limit there is: at what the plan takes it is compiled, at one less it is refused.
TEST(Limits, EachIsRefusedOneBelowWhatAPlanTakes) {
    size_t tried = 0;
    for (const char* name : {"hybrid_shadows", "shadows", "reflections"}) {
        const CheckedPipeline pipeline = shipped_pipeline(name);
        constexpr Extent extent{333, 77};
        Diagnostics diagnostics;
        const auto plan =
            compile(pipeline, {.extent = extent, .device = reference_device()}, {}, diagnostics);
        ASSERT_TRUE(plan) << diagnostics.text();
        DeviceTable tight = reference_device();
        for (const NeededLimit& need : needed_limits(*plan)) tight.limits[need.name] = need.value;
        tight.memory_bytes = plan->memory.heap_bytes;
        EXPECT_EQ(refusal(pipeline, extent, tight), "") << name;
        for (const NeededLimit& need : needed_limits(*plan)) {
            if (need.value == 1) continue;
            DeviceTable less = tight;
            less.limits[need.name] = need.value - 1;
            const std::string text = refusal(pipeline, extent, less);
            EXPECT_NE(text.find((need.pass ? "nodes." : "") + need.why + ": it takes " +
                                std::to_string(need.value) + " of " + need.name + ", 1 more than the " +
                                std::to_string(need.value - 1) + " of the device \"reference gpu\""),
                      std::string::npos)
                << name << ": " << text;
            EXPECT_EQ(text.find('\n'), text.size() - 1) << "one message: " << text;
            ++tried;
        }
        --tight.memory_bytes;
        EXPECT_NE(refusal(pipeline, extent, tight).find("MiB of memory"), std::string::npos) << name;
    }
    EXPECT_GT(tried, 40u);
}

// The most of any pass or resource, whichever comes first.
TEST(Limits, WhatAPlanTakesIsTheMostThatAnyPassTakes) {
    for (const char* name : {"hybrid_shadows", "reflections"}) {
        Diagnostics diagnostics;
        const auto plan = compile(shipped_pipeline(name), {.extent = {333, 77}, .device = reference_device()},
                                  {}, diagnostics);
        ASSERT_TRUE(plan) << diagnostics.text();
        std::map<std::string, uint64_t> most;
        const auto take = [&](const char* limit, uint64_t value) {
            most[limit] = std::max(most[limit], value);
        };
        for (const PlanPass& pass : plan->passes) {
            if (pass.kind != PassKind::compute) continue;
            take("maxComputeWorkGroupCount[0]", pass.groups[0]);
            take("maxComputeWorkGroupInvocations",
                 uint64_t{pass.constants[0]} * pass.constants[1] * pass.constants[2]);
            take("maxPushConstantsSize", pass.push.size());
            take("maxPerStageResources", pass.bindings.size());
            take("maxComputeSharedMemorySize", workgroup_bytes(plan->modules[*pass.module], pass.constants));
        }
        for (const Heap& heap : plan->heaps) take("maxMemoryAllocationSize", heap.bytes);
        std::erase_if(most, [](const auto& limit) { return limit.second == 0; });
        size_t seen = 0;
        for (const NeededLimit& need : needed_limits(*plan))
            if (const auto at = most.find(need.name); at != most.end()) {
                EXPECT_EQ(need.value, at->second) << name << ": " << need.name;
                ++seen;
            }
        EXPECT_EQ(seen, most.size()) << name;
    }
}

// Counts of workgroups, in the declaration's own hand: the device decides, not a number of ours.
TEST(Limits, ADispatchIsHeldToTheDevices) {
    DeviceTable device = reference_device();
    device.limits["maxComputeWorkGroupCount[0]"] = 10;
    const std::string text = refusal(shipped_pipeline("raw"), {1024, 8}, device);
    EXPECT_NE(text.find("of maxComputeWorkGroupCount[0], "), std::string::npos) << text;
    EXPECT_NE(text.find("pipelines/raw.json:"), std::string::npos) << "no place: " << text;
}

uint64_t bytes_of(const std::string& declarations, std::vector<uint32_t> constants = {}) {
    ShaderSource source{.file = "shared.comp", .node_glsl = {}, .include_dirs = {}};
    source.node_glsl =
        "layout(local_size_x_id = 0, local_size_y_id = 1) in;\n"
        "layout(set = 0, binding = 0) buffer Out { float seen[]; };\n";
    source.text = "#version 460\n#include \"node.glsl\"\n" + declarations;
    Diagnostics diagnostics;
    const auto shader = compile_shader(source, diagnostics);
    if (!shader) throw std::runtime_error(diagnostics.text());
    return workgroup_bytes(shader->spirv, constants);
}

// By hand, from std430; the optimiser drops what is not used.
TEST(Limits, SharedMemoryIsCounted) {
    const std::string use = "void main() { uint i = gl_LocalInvocationIndex; ";
    EXPECT_EQ(bytes_of(use + "}"), 0u);
    EXPECT_EQ(bytes_of("shared uint a[5];" + use + "atomicAdd(a[i], 1u); }"), 20u);
    EXPECT_EQ(bytes_of("shared vec3 a[5];" + use + "a[i] = vec3(i); barrier(); seen[i] = a[4 - i].y; }"),
              80u);
    EXPECT_EQ(bytes_of("shared uint a[5]; shared vec3 b[2];" + use +
                       "a[i] = i; b[i] = vec3(i); barrier(); seen[i] = b[1 - i].y + a[4 - i]; }"),
              64u)
        << "20 bytes of one, 12 between them, 32 of the other: either may come first";
    EXPECT_EQ(bytes_of("struct S { float f; vec2 v; }; shared S a[3];" + use +
                       "a[i].f = 1.0; a[i].v = vec2(i); barrier(); seen[i] = a[2 - i].v.x + a[2 - i].f; }"),
              48u);
    const std::string sized =
        "layout(constant_id = 2) const uint N = 7u; const uint M = (gl_WorkGroupSize.x * "
        "gl_WorkGroupSize.y + N - 1u) / N; shared uint a[M];" +
        use + "atomicAdd(a[i], 1u); }";
    EXPECT_EQ(bytes_of(sized, {32, 4}), 4 * ((32 * 4 + 6) / 7)) << "N has its own value";
    EXPECT_EQ(bytes_of(sized, {32, 4, 2}), 4 * 64u);
    EXPECT_EQ(
        bytes_of("layout(constant_id = 2) const bool B = true; const uint M = B ? gl_WorkGroupSize.x << 2 : "
                 "1u; shared uint a[M];" +
                     use + "atomicAdd(a[i], 1u); }",
                 {8, 1, 0}),
        4u);
    for (const std::vector<uint32_t>& broken :
         {std::vector<uint32_t>{}, {1, 2, 3, 4, 5, 59}, {1, 2, 3, 4, 5, 0xffff0000u + 59}})
        EXPECT_EQ(workgroup_bytes(broken, {}), 0u);
}

class ShippedSizes : public ::testing::TestWithParam<std::string> {};

TEST_P(ShippedSizes, LongNarrowAndLargeOnesCompile) {
    const CheckedPipeline pipeline = shipped_pipeline(GetParam());
    for (const Extent extent : {Extent{16384, 1}, {1, 16384}, {7680, 4320}, {1, 1}})
        EXPECT_EQ(refusal(pipeline, extent, reference_device()), "") << extent.width << "x" << extent.height;
    // The square of 8K takes a buffer of some that a device need not have.
    const std::string square = refusal(pipeline, {8192, 8192}, reference_device());
    if (!square.empty()) {
        EXPECT_NE(square.find(" bytes exceed the device's largest storage buffer, 134217728, by 134217"),
                  std::string::npos)
            << square;
    }
    for (const Extent extent : {Extent{16385, 1}, {1, 16385}, {~0u, ~0u}, {1, ~0u}})
        EXPECT_NE(
            refusal(pipeline, extent, reference_device()).find("exceeds the device's largest image, 16384"),
            std::string::npos)
            << extent.width << "x" << extent.height;
}

INSTANTIATE_TEST_SUITE_P(Pipelines, ShippedSizes, ::testing::ValuesIn([] {
                             std::vector<std::string> names = names_in("pipelines", ".json");
                             std::erase_if(names,
                                           [](const std::string& name) { return name.ends_with(".schema"); });
                             return names;
                         }()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace penumbra::test
