// SPDX-License-Identifier: MIT
// What one more light takes in lights_shadows.json: its past and its mask, and little beside them.
#include <gtest/gtest.h>

#include "penumbra/graph.h"
#include "tests/shipped.h"

namespace penumbra::test {
namespace {

Plan plan_with(uint32_t lights) {
    std::string members;
    for (uint32_t i = 0; i < lights; ++i)
        members += (i ? ", \"l" : "\"l") + std::to_string(i) + R"(": {"of": "lights"})";
    Diagnostics diagnostics;
    const CheckedPipeline pipeline =
        shipped_pipeline("lights_shadows", {"instances=null", "instances={" + members + "}"});
    Target target;
    target.extent = {1920, 1080};
    target.device = reference_device();
    auto plan = compile(pipeline, target, {}, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::move(*plan);
}

// Per pixel of 1920x1080.
double bytes_with(uint32_t lights) {
    return static_cast<double>(plan_with(lights).memory.heap_bytes) / (1920 * 1080);
}

// So that an heir with one more hands on what the others have.
TEST(LightsMemory, WhatIsOfOneLightMayBeginCleared) {
    const Plan plan = plan_with(3);
    size_t of_lights = 0;
    for (const ResetAction& action : plan.reset) {
        const std::string& name = plan.resources[action.resource].names.back();
        if (!name.ends_with("_l0") && !name.ends_with("_l1") && !name.ends_with("_l2")) continue;
        EXPECT_TRUE(action.clear) << name;
        ++of_lights;
    }
    EXPECT_EQ(of_lights, 6u);
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
