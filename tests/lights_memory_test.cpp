// SPDX-License-Identifier: MIT
// What one more light takes in lights_shadows.json: its past and its mask, and little beside them.
#include <gtest/gtest.h>

#include <filesystem>

#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"

namespace penumbra::test {
namespace {

// Per pixel of 1920x1080.
double bytes_with(uint32_t lights) {
    std::string members;
    for (uint32_t i = 0; i < lights; ++i)
        members += (i ? ", \"l" : "\"l") + std::to_string(i) + R"(": {"of": "lights"})";
    Diagnostics diagnostics;
    const std::string settings[] = {"instances=null", "instances={" + members + "}"};
    const auto pipeline = load_pipeline(
        std::filesystem::path(PENUMBRA_SOURCE_DIR) / "pipelines/lights_shadows.json", settings, diagnostics);
    static const NodeSet nodes = shadow_nodes();
    const auto checked = pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
    Target target;
    target.extent = {1920, 1080};
    target.device = reference_device();
    const auto plan = checked ? compile(*checked, target, {}, diagnostics) : std::nullopt;
    if (!plan) throw std::runtime_error(diagnostics.text());
    return static_cast<double>(plan->memory.heap_bytes) / (1920 * 1080);
}

TEST(LightsMemory, IsAtMostTenBytesPerPixelForEachFurtherLight) {
    double before = bytes_with(1);
    EXPECT_LT(before, 41);
    for (uint32_t lights = 2; lights <= 12; ++lights) {
        const double bytes = bytes_with(lights);
        EXPECT_LE(bytes - before, 10) << lights;
        EXPECT_GT(bytes - before, 6) << "the past and the mask of " << lights;
        before = bytes;
    }
}

}  // namespace
}  // namespace penumbra::test
