// SPDX-License-Identifier: MIT
// The scenes that the project makes itself: the same bytes every time, solids without holes, and shots in
// scenes/ that find the objects they move.
#include "host/generated/generated_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "host/models/glb_writer.h"
#include "host/models/shapes.h"
#include "host/scene/scene.h"
#include "host/scene/scene_facts.h"
#include "tests/bvh_scenes.h"

namespace penumbra {
namespace {

const std::filesystem::path scenes_folder = std::filesystem::path(PENUMBRA_SOURCE_DIR) / "scenes";

Shot shipped_shot(const std::string& name) {
    Diagnostics diagnostics;
    const std::string file = name + ".shot.json";
    std::string folder;
    for (const char* of : {"lights", "radiance"})
        if (std::filesystem::exists(scenes_folder / of / file)) folder = of;
    const std::optional<Shot> shot = read_shot(scenes_folder / folder / file, diagnostics);
    EXPECT_TRUE(shot) << diagnostics.text();
    return shot.value_or(Shot{});
}

TEST(GeneratedScenes, AreTheSameBytesEveryTimeAndSmall) {
    for (const GeneratedScene& scene : generated_scenes) {
        const Model model = scene.make();
        const std::vector<std::byte> bytes = to_glb(model);
        EXPECT_EQ(bytes, to_glb(scene.make())) << scene.name;
        EXPECT_LT(bytes.size(), 20'000'000u) << scene.name;
        size_t shown = 0;
        for (const Node& node : model.nodes)
            if (node.mesh >= 0)
                for (const Part& part : model.meshes[static_cast<size_t>(node.mesh)].parts)
                    shown += part.indices.size() / 3;
        EXPECT_LE(shown, 300'000u) << scene.name;
    }
}

// Edges by position: in a closed, consistently wound solid each is used as often in one direction as in the
// other.
size_t open_edges(const Part& part) {
    using Point = std::array<float, 3>;
    const auto at = [&](uint32_t i) {
        return Point{part.positions[i].x, part.positions[i].y, part.positions[i].z};
    };
    std::map<std::pair<Point, Point>, int> balance;
    for (size_t i = 0; i < part.indices.size(); i += 3)
        for (size_t k = 0; k < 3; ++k) {
            const Point a = at(part.indices[i + k]), b = at(part.indices[i + (k + 1) % 3]);
            if (a == b) continue;
            if (a < b)
                ++balance[{a, b}];
            else
                --balance[{b, a}];
        }
    size_t open = 0;
    for (const auto& [edge, count] : balance) open += count != 0;
    return open;
}

double signed_volume(const Part& part) {
    double volume = 0;
    for (size_t i = 0; i < part.indices.size(); i += 3) {
        const glm::dvec3 a(part.positions[part.indices[i]]), b(part.positions[part.indices[i + 1]]),
            c(part.positions[part.indices[i + 2]]);
        volume += glm::dot(a, glm::cross(b, c)) / 6;
    }
    return volume;
}

TEST(GeneratedScenes, SolidsAreClosedAndWoundOutwards) {
    const std::set<std::string> sheets{"back",    "floor",  "hills",   "left",   "light",
                                       "plain",   "paving", "right",   "street", "end",
                                       "terrain", "panes",  "curtain", "sheet",  "sheet_fixed"};
    for (const GeneratedScene& scene : generated_scenes) {
        const Model model = scene.make();
        size_t checked = 0;
        for (const Node& node : model.nodes) {
            if (node.mesh < 0 || sheets.contains(node.name)) continue;
            const std::vector<Part>& parts = model.meshes[static_cast<size_t>(node.mesh)].parts;
            for (size_t p = 0; p < parts.size(); ++p) {
                const bool trees = scene.name == std::string("trees") || scene.name == std::string("cards"),
                           leaves = trees && p == 1;
                if (leaves) continue;
                ++checked;
                EXPECT_EQ(open_edges(parts[p]), 0u) << scene.name << ": " << node.name;
                EXPECT_GT(signed_volume(parts[p]), 0) << scene.name << ": " << node.name;
            }
        }
        EXPECT_GT(checked, 4u) << scene.name;
    }
}

TEST(GeneratedScenes, ShotsFindWhatTheyMove) {
    for (const GeneratedScene& scene : generated_scenes) {
        const Shot shot = shipped_shot(scene.name);
        Diagnostics diagnostics;
        EXPECT_TRUE(check_objects(shot, scene.make(), diagnostics)) << diagnostics.text();
        EXPECT_EQ(shot.model.filename(), std::string(scene.name) + ".glb");
        EXPECT_EQ(shot.frames, 64u);
    }
    EXPECT_TRUE(shipped_shot("fan").objects.contains("fan_wall"));
    EXPECT_TRUE(shipped_shot("fan").objects.contains("fan_ceiling"));
    EXPECT_TRUE(shipped_shot("lamp").objects.contains("lamp"));
}

TEST(GeneratedScenes, TheLampsShotIsTheGeneratorsText) {
    std::ifstream file(scenes_folder / "lamp.shot.json");
    std::stringstream text;
    text << file.rdbuf();
    EXPECT_EQ(text.str(), make_lamp_shot()) << "run penumbra_make_scenes scenes";
}

// A blade never turns so far between frames that the rotor seems to stand still or to run backwards.
TEST(GeneratedScenes, FansTurnByLessThanHalfTheirBladesSpacing) {
    const Shot shot = shipped_shot("fan");
    const auto step = [&](const char* name) {
        const ObjectMotion& motion = shot.objects.at(name);
        return glm::length(object_at(motion, 11).rotation_deg - object_at(motion, 10).rotation_deg);
    };
    EXPECT_GT(step("fan_wall"), 5);
    EXPECT_LT(step("fan_wall"), 0.5 * 360 / 5);
    EXPECT_GT(step("fan_ceiling"), 1);
    EXPECT_LT(step("fan_ceiling"), 0.5 * 360 / 4);
}

// Between keys the joints turn linearly, so a sole may leave the ground by the millimetres of that error.
TEST(GeneratedScenes, WalkersStandOnTheGround) {
    const Shot shot = shipped_shot("lamp");
    const Model model = make_lamp();
    const Scene scene(make_lamp(), shot);
    for (int frame = 0; frame < 64; ++frame) {
        const std::vector<glm::dmat4> world = scene.transforms(frame);
        std::map<std::string, double> lowest;
        for (size_t i = 0; i < model.nodes.size(); ++i) {
            if (!model.nodes[i].name.starts_with("walker_")) continue;
            double& low = lowest.try_emplace(model.nodes[i].name.substr(0, 8), 1e9).first->second;
            for (const Part& part : model.meshes[static_cast<size_t>(model.nodes[i].mesh)].parts)
                for (const glm::vec3& p : part.positions)
                    low = std::min(low, (world[i] * glm::dvec4(part.origin + glm::dvec3(p), 1)).y);
        }
        ASSERT_EQ(lowest.size(), 3u);
        for (const auto& [name, low] : lowest) EXPECT_NEAR(low, 0, 0.012) << name << ", frame " << frame;
    }
}

TEST(SceneFacts, ACastersWidthIsItsNarrowSideSeenFromTheSun) {
    std::vector<Triangle> triangles;
    test::add_box(triangles, {0, 0, 0}, {4, 0.1f, 0.5f});   // from above: 4 x 0.5
    test::add_box(triangles, {0, 2, 0}, {0.2f, 3, 0.03f});  // 0.2 x 0.03
    test::add_box(triangles, {0, 3, 0},
                  {0.2f, 4, 0.03f});  // touches the one below it: one caster of one object ..
    const std::vector<uint32_t> one(36, 0);
    std::vector<uint32_t> two(36, 0);
    std::fill(two.begin() + 24, two.end(), 1u);  // .. and two casters of two objects
    EXPECT_EQ(caster_widths(triangles, two, {0, 1, 0}).width_m.size(), 3u);
    const std::vector<double> widths = caster_widths(triangles, one, {0, 1, 0}).width_m;
    ASSERT_EQ(widths.size(), 2u);
    EXPECT_NEAR(widths[0], 0.5, 1e-6);
    EXPECT_NEAR(widths[1], 0.03, 1e-6);
    EXPECT_NEAR(caster_widths(triangles, one, {0, 0, 1}).width_m[0], 0.1, 1e-6);
}

TEST(SceneFacts, WhatLetsLightThroughIsNoCaster) {
    Model model;
    Material glass;
    glass.transmission = 1;
    model.materials = {{}, glass};
    const Shape solid = box({0, 0, 0}, {1, 1, 1}), pane = box({3, 0, 0}, {4, 1, 1});
    model.meshes.push_back({{to_part(solid, 0), to_part(pane, 1)}});
    model.nodes = {Node{.name = "both", .mesh = 0}};
    const Scene scene(std::move(model), Shot{});
    EXPECT_EQ(caster_widths(scene.triangles(0), scene.triangle_objects(), {0, 1, 0}).width_m.size(), 1u);
}

}  // namespace
}  // namespace penumbra
