// SPDX-License-Identifier: MIT
// Images that shaders write as buffers, where the device says that this is quicker: which ones, and what
// their plans say of it.
#include <gtest/gtest.h>

#include <algorithm>

#include "graph/interface.h"
#include "tests/compile_text.h"
#include "tests/toy_nodes.h"

namespace penumbra::test {
namespace {

NodeSet set_of(const std::string& output) {
    NodeSet set;
    set.add(
        {.type = parse_toy(R"({ "node": "paint", "doc": "d", "shader": "s.comp", "outputs": { "value": )" +
                               output + R"( }, "dispatch": { "over": "value" } })",
                           "paint")});
    return set;
}

Target rows_target(uint64_t row_bytes) {
    Target target = target_of({100, 30}, true);
    target.device.row_bytes = [=](const ImageNeed&) { return row_bytes; };
    return target;
}

Plan paint(const std::string& output, const Target& target, const CompileOptions& options = {}) {
    const auto compiled =
        compile_text(set_of(output), R"("outputs": ["value"], "nodes": { "paint": { "type": "paint" } })",
                     target, options);
    EXPECT_EQ(compiled.errors, "");
    return compiled.plan.value();
}

// The buffer beside a storage image, and how many of its elements a row has; 0: there is none.
uint32_t elements_of(const Plan& plan) {
    const PlanPass& pass = plan.passes.front();
    const auto image = std::ranges::find(pass.bindings, "value", &PlanBinding::port);
    EXPECT_EQ(std::ranges::count(pass.bindings, true, &PlanBinding::output), 1);
    const auto buffer = std::ranges::find(pass.bindings, image->binding + 1, &PlanBinding::binding);
    EXPECT_EQ(buffer == pass.bindings.end(), plan.resources[0].row_bytes == 0);
    EXPECT_EQ(pass.variant, buffer == pass.bindings.end() ? "" : "rows=1");
    if (buffer == pass.bindings.end()) return 0;
    EXPECT_EQ(buffer->type, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
    EXPECT_EQ(buffer->binding, image->binding + 1);
    EXPECT_EQ(buffer->index, image->index);
    return pass.constants.back();
}

TEST(Rows, AnImageHasThemWhereTheDeviceSaysSo) {
    const std::string half4 = R"({ "kind": "image", "format": "rgba16f", "in_rows": true })";
    const Plan with = paint(half4, rows_target(832)), without = paint(half4, target_of({100, 30}, true));
    EXPECT_EQ(with.resources[0].row_bytes, 832u);
    EXPECT_EQ(with.resources[0].buffer_bytes(), 832u * 30);
    EXPECT_GE(with.resources[0].bytes, 832u * 30);
    EXPECT_EQ(elements_of(with), 832u / 8);
    EXPECT_EQ(without.resources[0].row_bytes, 0u);
    EXPECT_EQ(elements_of(without), 0u);
}

TEST(Rows, NotIfARowIsNoWholeNumberOfElementsOrTheBufferIsTooLarge) {
    const std::string half4 = R"({ "kind": "image", "format": "rgba16f", "in_rows": true })";
    EXPECT_EQ(paint(half4, rows_target(804)).resources[0].row_bytes, 0u);
    EXPECT_EQ(paint(half4, rows_target(0)).resources[0].row_bytes, 0u);
    Target small = rows_target(832);
    small.device.max_storage_bytes = 832 * 30 - 1;
    EXPECT_EQ(paint(half4, small).resources[0].row_bytes, 0u);
    small.device.max_storage_bytes = 832 * 30;
    EXPECT_EQ(paint(half4, small).resources[0].row_bytes, 832u);
}

// Four of its texels are a word, or two.
TEST(Rows, ANarrowImageHasThem) {
    EXPECT_EQ(elements_of(paint(R"({ "kind": "image", "format": "r8", "in_rows": true })", rows_target(128))),
              32u);
    EXPECT_EQ(
        elements_of(paint(R"({ "kind": "image", "format": "r16f", "in_rows": true })", rows_target(256))),
        32u);
}

TEST(Rows, AnImageOfTheHostsHasNone) {
    CompileOptions options;
    options.outputs["value"].host_image = true;
    const Plan plan =
        paint(R"({ "kind": "image", "format": "rgba16f", "in_rows": true })", rows_target(832), options);
    EXPECT_EQ(elements_of(plan), 0u);
}

// Nor has one whose declaration does not say that its shader is compiled for it.
TEST(Rows, AnImageThatDoesNotAskHasNone) {
    EXPECT_EQ(elements_of(paint(R"({ "kind": "image", "format": "rgba16f" })", rows_target(832))), 0u);
}

}  // namespace
}  // namespace penumbra::test
