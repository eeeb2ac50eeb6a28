// SPDX-License-Identifier: MIT
// A host that has ray queries and does not bring penumbra's tree: no pipeline asks it for any part of that.
#include <algorithm>

#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr const char* tracers[] = {
    "shadows", "hybrid_shadows", "hybrid_shadows_best", "covered", "many_rays", "one_ray", "raw"};

class NoTreeGpu : public GpuTest {};

TEST_F(NoTreeGpu, NoSlotIsThatOfATree) {
    const auto of_tree = [](const HostSlot& slot) {
        return slot.name == "scene.nodes" || slot.name == "scene.leaves" || slot.name == "neighbours";
    };
    for (const char* name : tracers)
        for (const bool cpu : {false, true}) {  // where `auto` would rather take the tree
            const CheckedPipeline pipeline = shipped_pipeline(name);
            Target target{.extent = {96, 54}, .device = reference_device(cpu)};
            target.device.features = {"ray_query", "storage8"};
            for (const bool sun_disc : {false, true}) {
                Diagnostics diagnostics;
                target.facts = {{"tree", false}, {"sun_disc", sun_disc}};
                const auto plan = compile(pipeline, target, {}, diagnostics);
                ASSERT_TRUE(plan) << name << ": " << diagnostics.text();
                EXPECT_TRUE(std::ranges::none_of(plan->slots, of_tree)) << name;
                EXPECT_TRUE(plan->slot("scene.tlas")) << name;
                const auto needs = requirements(*plan);
                EXPECT_NE(std::ranges::find(needs, "VK_KHR_ray_query", &Requirement::name), needs.end())
                    << name;
                EXPECT_EQ(unmet(*plan, handles_of(gpu())).empty(), gpu().caps().ray_query) << name;
                EXPECT_TRUE(plan->output("visibility")) << name;
            }
            target.device.features = {"storage8"};
            Diagnostics diagnostics;
            EXPECT_FALSE(compile(pipeline, target, {}, diagnostics)) << name;
            EXPECT_NE(diagnostics.text().find("lacks ray_query"), std::string::npos) << diagnostics.text();
            EXPECT_NE(diagnostics.text().find("the fact \"tree\" does not hold"), std::string::npos)
                << diagnostics.text();
        }
}

// A node that can do nothing but walk the tree says so, where a pipeline does not leave it out.
TEST_F(NoTreeGpu, WhatWalksTheTreeCannotRunWithout) {
    const CheckedPipeline pipeline =
        shadow_pipeline(R"({ "penumbra": 1, "name": "p", "extends": ")" PENUMBRA_SOURCE_DIR
                        R"(/pipelines/many_rays.json",
        "nodes": { "beams": { "if": null }, "trace": { "if": null }, "trace_queries": null } })");
    Target target{.extent = {96, 54}, .facts = {{"tree", false}}, .device = reference_device()};
    target.device.features = {"ray_query"};
    Diagnostics diagnostics;
    EXPECT_FALSE(compile(pipeline, target, {}, diagnostics));
    EXPECT_NE(diagnostics.text().find("nodes.beams: \"bvh\": the fact \"tree\" does not hold"),
              std::string::npos)
        << diagnostics.text();
}

std::vector<float> visibility_of(const char* name, bool tree) {
    ShotRun run(name, plaza_shot({96, 54}, 4), {.facts = {{"tree", tree}}});
    EXPECT_EQ(run.session().bvh() != nullptr, tree) << name;
    return run.up_to(3);
}

TEST_F(NoTreeGpu, TheImageIsThatOfTheTree) {
    if (!gpu().caps().ray_query) GTEST_SKIP() << "this device has no ray queries";
    for (const char* name : {"shadows", "hybrid_shadows", "covered"}) {
        const std::vector<float> with = visibility_of(name, true), without = visibility_of(name, false);
        double shadow = 0;
        for (const float v : without) shadow += 1 - double(v);
        std::printf("%s without a tree: RMSE %.4f against it\n", name, rms(with, without));
        EXPECT_LT(rms(with, without), 0.05) << name;
        EXPECT_GT(shadow, 0.01 * double(with.size())) << name;
    }
}

}  // namespace
}  // namespace penumbra::test
