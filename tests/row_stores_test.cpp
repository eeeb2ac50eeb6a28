// SPDX-License-Identifier: MIT
// store_NAME() and store4_NAME() as a buffer and as an image: the same texels, of every format, at an extent
// that no row and no group fits, and nothing beside the image.
#include <fmt/format.h>

#include <fstream>
#include <set>

#include "graph/interface.h"
#include "penumbra/shadow_nodes.h"
#include "penumbra/user_nodes.h"
#include "tests/embedding_host.h"
#include "tests/test_folder.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr Extent extent{37, 11};

class RowStores : public GpuTest, public ::testing::WithParamInterface<const char*> {
  protected:
    // What the whole image holds after a frame; `rows`: whether the device may say how its rows lie.
    std::vector<uint8_t> painted(const CheckedPipeline& pipeline, bool rows) {
        Target target{.extent = extent, .device = device_table(handles_of(gpu()))};
        says_ = target.device.row_bytes != nullptr;
        if (!rows) target.device.row_bytes = nullptr;
        CompileOptions options;
        options.captures = {"value"};
        options.poison = true;
        Diagnostics diagnostics;
        auto plan = compile(pipeline, target, options, diagnostics);
        if (!plan) throw std::runtime_error(diagnostics.text());
        row_bytes_ = plan->resources[0].row_bytes;
        View view(
            std::make_shared<Program>(handles_of(gpu()), std::make_shared<const Plan>(std::move(*plan))),
            {.poison = 0x7fc00000u});
        gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(0, extent), {}); });
        return captured<uint8_t>(view, "value");
    }
    bool says_ = false;
    uint64_t row_bytes_ = 0;
};

// Also where nobody should: beside the image, from the next row's point of view within it.
TEST_P(RowStores, AreTheImages) {
    const Format format = format_named(GetParam()).value();
    const bool whole = info(format).kind == FormatClass::uint, narrow = info(format).bytes < 4;
    const char* type = whole ? "uvec4" : "vec4";
    // Halves and bytes that the format has exactly.
    const std::string color =
        whole ? "uvec4(n, n * 3u, n * 5u, n * 7u)"
              : "vec4(n & 15u, n >> 4 & 15u, n >> 8 & 7u, 3u) / vec4(15.0, 15.0, 7.0, 3.0)";
    // Of floats any but NaN: too large, denormal, between two halves, infinite.
    const std::string any =
        "uintBitsToFloat(n % 7u == 0u ? uvec4(0x7f800000u) : n * uvec4(10534519u, 10533001u, 10531013u, "
        "10529003u) & 0xf7ffffffu)";
    const std::string stored = info(format).kind == FormatClass::real ? any : color;
    const TestFolder folder;
    std::ofstream(folder / "toy_paint.json") << fmt::format(
        R"({{ "node": "toy_paint", "doc": "d", "shader": "toy_paint.comp",
        "outputs": {{ "value": {{ "kind": "image", "format": "{}", "in_rows": true }} }},
        "dispatch": {{ "over": "value", "group": [8, 8] }} }})",
        GetParam());
    const std::string store = narrow ? R"(
    if (p.x % 4 == 0) {
        vec4 four;
        for (int i = 0; i < 4; ++i) four[i] = color(uint(37 * p.y + p.x + i)).x;
        store4_value(p, four);
        store4_value(p - ivec2(48, 0), vec4(1.0));
        store4_value(p - ivec2(0, 16), vec4(1.0));
        store4_value(p + ivec2(64, 0), vec4(1.0));
    })"
                                     : fmt::format(R"(
    store_value(p, color(uint(37 * p.y + p.x)));
    store_value(p - ivec2(48, 0), {0}(1));
    store_value(p - ivec2(0, 16), {0}(1));
    store_value(p + ivec2(64, 0), {0}(1));
    store_value(p + ivec2(0, 16), {0}(1));)",
                                                   type);
    std::ofstream(folder / "toy_paint.comp")
        << "#include \"node.glsl\"\n"
        << fmt::format("{} color(uint n) {{ return {}; }}\n", type, stored)
        << "void main() {\n    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);" << store << "\n}\n";
    NodeSet set;
    Diagnostics diagnostics;
    ASSERT_TRUE(add_user_nodes(set, folder, diagnostics, open_shader_cache(""))) << diagnostics.text();
    const CheckedPipeline pipeline =
        checked(R"("outputs": ["value"], "nodes": { "paint": { "type": "toy_paint" } })", set);
    const auto as_image = painted(pipeline, false);
    EXPECT_EQ(row_bytes_, 0u);
    const auto as_rows = painted(pipeline, true);
    EXPECT_EQ(row_bytes_ != 0, says_ && row_element_bytes(format) != 0);
    EXPECT_EQ(as_rows, as_image);
    EXPECT_GT(std::set<uint8_t>(as_image.begin(), as_image.end()).size(), 8u);
}

INSTANTIATE_TEST_SUITE_P(Of, RowStores,
                         ::testing::Values("r8", "r16f", "rg16f", "rg16s", "rgba8", "rgba16f", "r32f",
                                           "rg32f", "rgba32f", "r32ui", "rg32ui", "rgba32ui", "rgb10a2"),
                         [](const auto& format) { return std::string(format.param); });

}  // namespace
}  // namespace penumbra::test
