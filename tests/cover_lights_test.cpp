// SPDX-License-Identifier: MIT
// Several lights in one pass: each mask is the one that its light has alone, to the bit; what they shine is
// the sum of what each shines on a surface that nothing shades, times its mask; and who is off or out of
// reach costs no step.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "tests/light_plate.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

constexpr std::array kinds = {LightKind::disc, LightKind::point,  LightKind::rectangle,
                              LightKind::spot, LightKind::sphere, LightKind::tube};

// Six lights, each of another kind and in another place, some of which see a part of the floor alone.
Shot six_lights(std::array<uint32_t, 2> size) {
    Shot shot = shot_with(LightKind::sphere, size);
    shot.lights.clear();
    for (size_t i = 0; i < kinds.size(); ++i) {
        ShotLight light = shot_with(kinds[i], size).lights.at("lamp");
        light.keys[0].position.x += 0.4 * double(i) - 1;
        light.range = 2.4 + 0.4 * double(i);
        light.strength = 100;
        light.color = {1, 0.5 + 0.1 * double(i), 0.3};
        shot.lights[fmt::format("light_{}", i)] = light;
    }
    return shot;
}

struct Frame {
    std::vector<std::vector<float>> masks;  // by light
    std::vector<std::array<float, 3>> lux;
    std::map<std::string, uint32_t> counters;
};

Frame rendered(const Shot& shot, const std::string& light = {}, std::vector<std::string> settings = {},
               const Facts& facts = {}) {
    settings.emplace_back("outputs=[\"masks\",\"illuminance\"]");
    const CheckedPipeline checked = shipped_pipeline("lights", settings);
    SessionOptions options;
    options.size = shot.size;
    options.captures = checked.output_names();
    options.light = light;
    options.facts = facts;
    const auto session = open_session(checked, shot, options, test_nodes());
    session->run_frame(0, true);
    Frame frame;
    const size_t pixels = size_t{shot.size[0]} * shot.size[1];
    const auto masks = session->view().captured("masks");
    for (size_t at = 0; at < masks.size(); at += pixels) {
        frame.masks.emplace_back();
        for (size_t i = 0; i < pixels; ++i)
            frame.masks.back().push_back(static_cast<float>(uint8_t(masks[at + i])) / 255);
    }
    const auto planes = captured_planes(session->view(), "illuminance");
    for (size_t i = 0; i < pixels; ++i) frame.lux.push_back({planes[0][i], planes[1][i], planes[2][i]});
    frame.counters = counters_of(session->view(), facts.contains("tree") ? "trace" : "cover");
    return frame;
}

std::vector<float> alone(Shot shot, const std::string& name) {
    ShotLight light = shot.lights.at(name);
    shot.lights = {{"lamp", light}};
    Diagnostics diagnostics;
    const auto session = open(shot, "light", {}, diagnostics);
    if (!session) throw std::runtime_error(diagnostics.text());
    session->run_frame(0, true);
    return captured_planes(session->view(), "visibility")[0];
}

class CoverLights : public GpuTest {};

TEST_F(CoverLights, EachMaskIsThatOfItsLightAlone) {
    for (const std::array<uint32_t, 2> size : {std::array{192u, 108u}, std::array{61u, 35u}}) {
        Shot shot = six_lights(size);
        const Frame all = rendered(shot);
        ASSERT_EQ(all.masks.size(), shot.lights.size());
        size_t layer = 0, soft = 0;
        for (const auto& [name, light] : shot.lights) {
            const std::vector<float> one = alone(shot, name);
            size_t differ = 0;
            for (size_t i = 0; i < one.size(); ++i) {
                differ += one[i] != all.masks[layer][i];
                soft += one[i] > 0 && one[i] < 1;
            }
            EXPECT_EQ(differ, 0u) << name << ", a " << name_of(light.kind);
            ++layer;
        }
        EXPECT_GT(soft, 300u);
        EXPECT_EQ(all.counters.at("asked") + all.counters.at("left"), 0u);
    }
}

// More lights than are tested at once, most of them off: the others keep their places.
TEST_F(CoverLights, OfFortyThoseThatAreOnKeepTheirLayers) {
    Shot shot = six_lights({64, 36});
    const ShotLight lamp = shot.lights.at("light_4");
    shot.lights.clear();
    for (int i = 0; i < 40; ++i) {
        ShotLight light = lamp;
        light.keys[0].position.x = 0.05 * i - 1;
        light.keys[0].power = i == 0 || i == 31 || i == 32 || i == 39;
        shot.lights[fmt::format("light_{:02}", i)] = light;
    }
    const Frame all = rendered(shot);
    ASSERT_EQ(all.masks.size(), 40u);
    uint32_t walked = 0;
    for (int i = 0; i < 40; ++i) {
        const std::string name = fmt::format("light_{:02}", i);
        if (shot.lights.at(name).keys[0].power > 0) {
            EXPECT_EQ(all.masks[size_t(i)], alone(shot, name)) << name;
            walked += rendered(shot, name).counters.at("walked");
        } else {
            EXPECT_EQ(std::ranges::count(all.masks[size_t(i)], 1.0f), 64 * 36) << name;
        }
    }
    EXPECT_EQ(all.counters.at("walked"), walked);
}

TEST_F(CoverLights, WhoIsOffOrOutOfReachIsNotWalkedTo) {
    Shot shot = six_lights({64, 36});
    const Frame before = rendered(shot);
    ShotLight off = shot.lights.at("light_4"), far = off, away = shot.lights.at("light_0"),
              turned = shot.lights.at("light_3");
    off.keys[0].power = 0;
    far.keys[0].position = {0, 900, 0};
    away.keys[0].direction = {0, 1, 0};  // a disc, and a spot
    turned.keys[0].direction = {0, 1, 0};
    shot.lights["more_0"] = off;
    shot.lights["more_1"] = far;
    shot.lights["more_2"] = away;
    shot.lights["more_3"] = turned;
    const Frame after = rendered(shot);
    EXPECT_GT(before.counters.at("walked"), 1000u);
    EXPECT_EQ(before.counters, after.counters);
    EXPECT_EQ(before.lux, after.lux);
    for (size_t layer = 6; layer < 10; ++layer)
        EXPECT_EQ(std::ranges::count(after.masks[layer], 1.0f), 64 * 36) << layer;
    for (const ShotLight& light : {off, far, away, turned}) {  // and where there is nothing else
        shot.lights = {{"lamp", light}};
        const Frame none = rendered(shot);
        EXPECT_EQ(none.counters.at("walked"), 0u);
        EXPECT_EQ(none.counters.at("steps"), 0u);
        EXPECT_EQ(none.lux, (std::vector<std::array<float, 3>>(64 * 36)));
    }
}

// A plan for six, of which the host brings two at the moment, both off.
TEST_F(CoverLights, WithoutALightForItALayerShadowsNothing) {
    const Shot shot = six_lights({64, 36});
    SessionOptions options;
    options.size = shot.size;
    options.captures = {"masks"};
    const auto session =
        open_session(shipped_pipeline("lights", {"outputs=[\"masks\"]"}), shot, options, test_nodes());
    session->run_frame(0, true);
    constexpr size_t bytes = 2 * 5 * 16;
    const GpuTexels two = make_host_texels(gpu(), bytes, VK_FORMAT_R32G32B32A32_UINT, "two lights");
    std::memset(two.buffer.mapped, 0, bytes);
    std::vector<SlotBinding> slots = session->bind_slots();
    slots[*session->plan().slot("lights")].texels = two.view.get();
    View view(std::make_shared<Program>(handles_of(gpu()), std::make_shared<Plan>(session->plan())), {});
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, session->frame_description(), slots); });
    const auto masks = view.captured("masks");
    ASSERT_EQ(masks.size(), 6u * 64 * 36);
    EXPECT_EQ(std::ranges::count(masks, std::byte{255}), std::ptrdiff_t(masks.size()));
}

// fp16 rounds by 2^-11 of a sum, which is of six; a mask by 1/510.
TEST_F(CoverLights, TheyShineTheSumOfWhatEachShinesThroughItsMask) {
    Shot shot = six_lights({96, 54}), bare = shot;
    bare.objects["plate"].keys = {{0, {0, -50, 0}, {}}};
    const Frame all = rendered(shot), open_floor = rendered(bare);
    std::vector<Frame> unshaded;
    for (const auto& [name, light] : shot.lights) unshaded.push_back(rendered(bare, name));
    const auto points = floor_points(shot);
    size_t lit = 0, shaded = 0;
    for (size_t i = 0; i < points.size(); ++i) {
        if (!points[i]) continue;
        for (size_t c = 0; c < 3; ++c) {
            double sum = 0, bound = 0;
            for (size_t layer = 0; layer < unshaded.size(); ++layer) {
                sum += double(unshaded[layer].lux[i][c]) * double(all.masks[layer][i]);
                bound += double(unshaded[layer].lux[i][c]) * (1 / 510.0 + 1 / 2048.0);
            }
            EXPECT_NEAR(all.lux[i][c], sum, bound + sum / 1024 + 1e-6) << i;
            lit += sum > 1;
            shaded += sum < 0.9 * double(open_floor.lux[i][c]);
        }
    }
    EXPECT_GT(lit, 5000u);
    EXPECT_GT(shaded, 500u);
}

// I cos / d^2 of a point, below its own range.
TEST_F(CoverLights, APointShinesItsCandelasOverTheSquareOfTheWay) {
    Shot shot = six_lights({64, 36});
    ShotLight light = shot.lights.at("light_1");
    light.radius = 0;
    light.range = 1e9;
    shot.lights = {{"lamp", light}};
    const Frame frame = rendered(shot);
    const auto points = floor_points(shot);
    size_t checked = 0;
    for (size_t i = 0; i < points.size(); ++i) {
        if (!points[i]) continue;
        const float mask = frame.masks[0][i];
        EXPECT_TRUE(mask == 0 || mask == 1) << i;
        const glm::dvec3 way = light.keys[0].position - *points[i];
        const double d = glm::length(way), lux = 100 * way.y / (d * d * d);
        EXPECT_NEAR(frame.lux[i][0], double(mask) * lux, 2e-3 * lux) << i;
        checked += mask == 1;
    }
    EXPECT_GT(checked, 1000u);
}

// Whoever gives up at once asks all samples by rays, and finds the same but where an edge lies within
// rounding of one. Of a ball that is sunk into the floor this one sees the upper part alone: rays that
// started a little on the way to its middle started below the floor.
TEST_F(CoverLights, WhatIsGivenUpIsAskedByRays) {
    Shot shot = six_lights({96, 54});
    ShotLight sunk = shot_with(LightKind::sphere, shot.size).lights.at("lamp");
    sunk.radius = 0.5;
    sunk.keys[0].position = {1, -0.1, 0.3};
    shot.lights["sunk"] = sunk;
    const Frame walked = rendered(shot), asked = rendered(shot, "", {"nodes.cover.params.budget=1"});
    EXPECT_GT(asked.counters.at("asked"), 1000u);
    double squares = 0;
    size_t count = 0;
    for (size_t layer = 0; layer < walked.masks.size(); ++layer)
        for (size_t i = 0; i < walked.masks[layer].size(); ++i) {
            const double difference = double(walked.masks[layer][i]) - double(asked.masks[layer][i]);
            EXPECT_LT(std::abs(difference), 0.1) << layer << " " << i;
            if (walked.masks[layer][i] == 0 || walked.masks[layer][i] == 1) continue;
            squares += difference * difference;
            ++count;
        }
    EXPECT_GT(count, 300u);
    EXPECT_LT(std::sqrt(squares / double(count)), 0.012);  // a sample and a half
}

// Sixty-four rays each, where a host has no tree.
TEST_F(CoverLights, WithoutATreeTheyAreRays) {
    if (!gpu().caps().ray_query) GTEST_SKIP() << "the device has no ray queries";
    const Shot shot = six_lights({32, 18});
    const Frame walked = rendered(shot), traced = rendered(shot, "", {}, {{"tree", false}});
    double expected = 0, squares = 0;
    for (size_t layer = 0; layer < walked.masks.size(); ++layer)
        for (size_t i = 0; i < walked.masks[layer].size(); ++i) {
            const double v = double(walked.masks[layer][i]), error = double(traced.masks[layer][i]) - v;
            expected += v * (1 - v);
            squares += error * error;
        }
    EXPECT_GT(expected / squares, 64);
    EXPECT_EQ(traced.counters.at("steps"), 0u);
}

TEST_F(CoverLights, AMaskIsAByteForEachPixelAndLight) {
    const auto bytes_per_pixel = [](uint32_t lights, const char* outputs) {
        Diagnostics diagnostics;
        const std::vector<std::string> settings{std::string("outputs=") + outputs};
        const auto checked = *check(
            *load_pipeline(fs::path(PENUMBRA_SOURCE_DIR) / "pipelines/lights.json", settings, diagnostics),
            test_nodes(), diagnostics);
        Target target = standalone_target(checked, reference_device(), {320, 192}, {});
        target.inputs["lights"] = {Format::rgba32ui, {5, lights}};
        const auto plan = compile(checked, target, {}, diagnostics);
        double bytes = 0;
        for (const PlanResource& r : plan->resources) bytes += double(r.bytes) / (320 * 192);
        return bytes;
    };
    for (const uint32_t lights : {1u, 6u, 12u}) {
        const char* masks = R"(["masks"])";
        EXPECT_NEAR(bytes_per_pixel(lights + 1, masks) - bytes_per_pixel(lights, masks), 1, 1e-9);
        EXPECT_EQ(bytes_per_pixel(lights, R"(["lit"])"), bytes_per_pixel(1, R"(["lit"])"));
    }
}

}  // namespace
}  // namespace penumbra::test
