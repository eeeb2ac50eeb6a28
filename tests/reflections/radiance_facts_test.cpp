// SPDX-License-Identifier: MIT
// What reflections cost by what the scene has: passes and bytes of plans, and images that stay the same to
// the bit where a fact is false.
#include <algorithm>
#include <span>
#include <stdexcept>

#include "host/models/model_builder.h"
#include "penumbra/shadow_nodes.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr std::array<uint32_t, 2> full_hd{1920, 1080};

Plan plan_of(const std::string& name, const Facts& facts = {}) {
    static const NodeSet nodes = shadow_nodes();
    Diagnostics diagnostics;
    const auto pipeline =
        load_pipeline(std::string(PENUMBRA_SOURCE_DIR "/pipelines/") + name + ".json", {}, diagnostics);
    const auto checked = pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
    auto plan = checked ? compile(*checked, standalone_target(*checked, reference_device(), full_hd, facts),
                                  {}, diagnostics)
                        : std::nullopt;
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::move(*plan);
}

size_t passes_of(const Plan& plan, const std::string& type) {
    return static_cast<size_t>(std::ranges::count(plan.passes, type, &PlanPass::type));
}
double bytes_per_pixel(uint64_t bytes) {
    return static_cast<double>(bytes) / (full_hd[0] * full_hd[1]);
}

TEST(RadiancePlan, TakesFortyBytesPerPixel) {
    for (const char* name : {"reflections", "indirect"}) {
        const MemoryReport memory = plan_of(name).memory;
        EXPECT_LE(bytes_per_pixel(memory.heap_bytes), 40) << name;
        EXPECT_LE(bytes_per_pixel(memory.persistent_bytes), 11.1) << name;
    }
}

TEST(RadiancePlan, LeavesOutWhatTheSceneDoesNotHave) {
    const Plan all = plan_of("reflections"), still = plan_of("reflections", {{"moves", false}}),
               mirrors = plan_of("reflections", {{"rough", false}}),
               matte = plan_of("reflections", {{"glossy", false}});
    EXPECT_EQ(passes_of(all, "radiance_tail"), 5u);
    EXPECT_EQ(passes_of(mirrors, "radiance_tail"), 1u);
    EXPECT_EQ(passes_of(plan_of("indirect", {{"rough", false}}), "radiance_tail"), 5u);
    EXPECT_EQ(passes_of(all, "reproject_radiance") + passes_of(all, "keep_surface"), 2u);
    EXPECT_EQ(passes_of(still, "reproject_radiance") + passes_of(still, "keep_surface"), 0u);
    EXPECT_LE(bytes_per_pixel(still.memory.heap_bytes), 35.1);
    EXPECT_LE(bytes_per_pixel(still.memory.persistent_bytes), 7.1);
    const auto has = [](const Plan& plan, const std::string& name) {
        return std::ranges::any_of(plan.resources,
                                   [&](const PlanResource& r) { return r.names.front() == name; });
    };
    EXPECT_TRUE(has(all, "past_image") && has(all, "ray_direction"));
    EXPECT_FALSE(has(matte, "past_image"));
    EXPECT_FALSE(has(mirrors, "ray_direction"));
    EXPECT_LT(matte.memory.unaliased_bytes, all.memory.unaliased_bytes);
    EXPECT_LT(mirrors.memory.heap_bytes, all.memory.heap_bytes);
}

// For a host that has texels of this extent for an optional input; of none where it is 0.
Plan plan_beside(const char* name, const std::string& input, Extent texels,
                 const std::vector<std::string>& settings) {
    static const NodeSet nodes = shadow_nodes();
    Diagnostics diagnostics;
    const auto pipeline =
        load_pipeline(std::string(PENUMBRA_SOURCE_DIR "/pipelines/") + name + ".json", settings, diagnostics);
    const auto checked = check(*pipeline, nodes, diagnostics);
    Target target = standalone_target(*checked, reference_device(), full_hd, {});
    if (texels.width && target.left_out.erase(input)) target.inputs[input] = {Format::rgba32ui, texels};
    return *compile(*checked, target, {}, diagnostics);
}

// A host without lamps, and one that has some.
TEST(RadiancePlan, LampsThatAreNotThereTakeNothing) {
    const auto plan_with = [](const char* name, bool lamps, const std::vector<std::string>& settings) {
        return plan_beside(name, "lights", lamps ? Extent{5, 3} : Extent{0, 0}, settings);
    };
    for (const char* name : {"lit", "lit_fast", "reference_lit"}) {
        const Plan with = plan_with(name, true, {}), without = plan_with(name, false, {}),
                   never = plan_with(name, false, {"nodes.lamps=null", "nodes.lamps_by_rays=null"});
        EXPECT_EQ(passes_of(with, "cover_lights"), 1u) << name;
        EXPECT_EQ(passes_of(without, "cover_lights"), 0u) << name;
        EXPECT_EQ(without.memory.heap_bytes, never.memory.heap_bytes) << name;
        EXPECT_EQ(without.memory.unaliased_bytes, never.memory.unaliased_bytes) << name;
        EXPECT_EQ(without.passes.size(), never.passes.size()) << name;
        EXPECT_EQ(with.memory.unaliased_bytes - without.memory.unaliased_bytes, uint64_t{1920} * 1080 * 8)
            << name;
        EXPECT_EQ(with.memory.persistent_bytes, without.memory.persistent_bytes) << name;
    }
    for (const char* name : {"reflections", "indirect", "raw_reflections", "relax", "fidelityfx_reflections",
                             "reference_radiance"})
        EXPECT_EQ(plan_with(name, true, {}).memory.heap_bytes, plan_with(name, false, {}).memory.heap_bytes)
            << name;
}

// A host that knows of nothing that shines, and one that does.
TEST(RadiancePlan, WhatShinesTakesAByteWhereItIsThere) {
    const auto plan_with = [](const char* name, bool emitters, const std::vector<std::string>& settings) {
        return plan_beside(name, "emitters", emitters ? Extent{6, 1} : Extent{0, 0}, settings);
    };
    for (const char* name : {"reflections", "indirect"}) {
        const Plan with = plan_with(name, true, {}), without = plan_with(name, false, {}),
                   never = plan_with(name, false, {"nodes.aim=null"});
        EXPECT_EQ(passes_of(with, "aim_rays"), 1u) << name;
        EXPECT_EQ(without.passes.size(), never.passes.size()) << name;
        EXPECT_EQ(without.memory.unaliased_bytes, never.memory.unaliased_bytes) << name;
        EXPECT_LE(bytes_per_pixel(with.memory.heap_bytes), 40.01) << name;
        EXPECT_EQ(with.memory.persistent_bytes, without.memory.persistent_bytes) << name;
    }
}

class RadianceFacts : public GpuTest {
  protected:
    // All images with what the scene says and with the fact taken for true.
    void expect_equal(const Shot& shot, const std::string& fact, bool jitter = true) {
        const auto measured = open_shipped("reflections", shot, {}, {}, {}, jitter);
        const auto claimed = open_shipped("reflections", shot, {}, {}, {{fact, true}}, jitter);
        EXPECT_LT(measured->plan().memory.unaliased_bytes, claimed->plan().memory.unaliased_bytes) << fact;
        float brightest = 0;
        for (uint32_t frame = 0; frame < shot.frames; ++frame) {
            measured->run_frame(frame, frame == 0);
            claimed->run_frame(frame, frame == 0);
            const auto image = colors(*measured);
            EXPECT_TRUE(image == colors(*claimed)) << fact << ", frame " << frame;
            brightest = std::max(brightest, *std::ranges::max_element(image[0]));
        }
        EXPECT_GT(brightest, 0.5f);
    }
};

Shot floor_under_the_sky(const std::vector<float>& roughness, bool moves) {
    Shot shot = night_shot(striped_floor(roughness), {64, 36}, 5);
    if (moves) shot.camera.push_back({5, {0.4, 1.4, 2.8}, {0.1, 0, 0}, {0, 1, 0}});
    shot.environment = linear_sky(0.1, 3);
    return shot;
}

TEST_F(RadianceFacts, NothingGlossyLooksTheSame) {
    expect_equal(floor_under_the_sky({0.6f, 0.9f}, true), "glossy");
}
TEST_F(RadianceFacts, NothingRoughLooksTheSame) {
    expect_equal(floor_under_the_sky({0}, true), "rough");
}
TEST_F(RadianceFacts, NothingMovingLooksTheSame) {
    expect_equal(floor_under_the_sky({0, 0.2f, 0.8f}, false), "moves", false);
}

// What a camera at rest sees mirrored was seen by the same pixel, wherever the jitter put the ray that
// looked.
TEST_F(RadianceFacts, AtRestTheImagesPastIsThePixelsOwn) {
    const Shot shot = floor_under_the_sky({0.1f, 0.2f}, false);
    const auto session =
        open_shipped("lit", shot, {}, {"past_surface", "past_image"}, {{"moves", true}}, true);
    for (uint32_t frame = 0; frame < shot.frames; ++frame) session->run_frame(frame, frame == 0);
    const auto surface = captured<uint32_t>(session->view(), "past_surface"),
               image = captured<uint32_t>(session->view(), "past_image");
    size_t both = 0, differ = 0;
    for (size_t i = 0; i < surface.size(); ++i) {
        if (!surface[i] || !image[i]) continue;
        ++both;
        differ += surface[i] != image[i];
    }
    EXPECT_GT(both, 500u);
    EXPECT_EQ(differ, 0u);
}

// A host that has nothing beyond its scene brings no environment, and neither does the program.
TEST_F(RadianceFacts, ABlackSkyIsLeftOut) {
    for (const double up : {0.0, 1.0}) {
        Shot shot = floor_under_the_sky({0.3f}, true);
        shot.environment = linear_sky(0, up);
        const auto session = open_shipped("reflections", shot);
        EXPECT_EQ(std::ranges::count(session->plan().slots, "environment", &HostSlot::name), up > 0);
        session->run_frame(0, true);
        EXPECT_EQ(*std::ranges::max_element(colors(*session)[0]) > 0, up > 0);
    }
}

// A ceiling that shines the same everywhere goes along itself: no ray can tell, but what it hits says that it
// moves, and that no past expects it there.
TEST_F(RadianceFacts, WhatRaysHitAndMovesHasNoLongPast) {
    Model model = striped_floor({0.4f});
    model.materials.push_back(shining({1, 1, 1}));
    model.meshes.push_back({{to_part(box({-900, 9, -900}, {900, 9.1, 900}), 1)}});
    Node node;
    node.mesh = static_cast<int>(model.meshes.size()) - 1;
    node.name = "ceiling";
    model.nodes.push_back(node);
    for (const double step_m : {0.0, 0.1}) {
        Shot shot = night_shot(model, {64, 36}, 9);
        shot.objects["ceiling"].keys = {{0, {0, 0, 0}, {}}, {8, {8 * step_m, 0, 0}, {}}};
        const auto session = open_shipped("reflections", shot, {}, {"frames"}, {}, false);
        for (uint32_t frame = 0; frame < 9; ++frame) session->run_frame(frame, frame == 0);
        const auto bytes = captured<uint8_t>(session->view(), "frames");
        const std::span floor =
            std::span(bytes).last(bytes.size() / 2);  // above are the sky and the ceiling itself
        const auto of_long = std::ranges::count_if(floor, [](uint8_t byte) {
            return (byte & 31) > 6;  // two frames: past_texel.glsl
        });
        EXPECT_NEAR(double(of_long) / double(floor.size()), step_m > 0 ? 0 : 1, 0.02);
    }
}

// Seen from a camera that goes ahead and carries it, a thing stands still: no still surface would have been
// at its depth.
TEST_F(RadianceFacts, WhatTheCameraCarriesKeepsItsPast) {
    Model model = striped_floor({0.4f});
    model.meshes.push_back({{to_part(box({-0.8, 0.1, -0.8}, {0.8, 0.9, 0.8}), 0)}});
    Node node;
    node.mesh = static_cast<int>(model.meshes.size()) - 1;
    node.name = "carried";
    model.nodes.push_back(node);
    constexpr uint32_t width = 64, height = 36, frames = 9;
    Shot shot = night_shot(model, {width, height}, frames);
    shot.environment = linear_sky(0.1, 3);
    CameraKey end = shot.camera.front();
    end.frame = frames - 1;
    end.position[2] -= 0.25 * (frames - 1);
    end.target[2] -= 0.25 * (frames - 1);
    shot.camera.push_back(end);
    shot.objects["carried"].keys = {{0, {0, 0, 0}, {}}, {frames - 1, {0, 0, -0.25 * (frames - 1)}, {}}};
    const auto session = open_shipped("reflections", shot, {"nodes.accumulate.params.moving_hit_frames=63"},
                                      {"frames"}, {}, false);
    for (uint32_t frame = 0; frame < frames; ++frame) session->run_frame(frame, frame == 0);
    const auto bytes = captured<uint8_t>(session->view(), "frames");
    for (uint32_t y = height / 2 - 3; y < height / 2 + 3; ++y)
        for (uint32_t x = width / 2 - 5; x < width / 2 + 5; ++x)
            EXPECT_GT(bytes[y * width + x] & 31, 6) << x << "," << y;
}

}  // namespace
}  // namespace penumbra::test
