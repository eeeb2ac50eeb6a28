// SPDX-License-Identifier: MIT
// Shots: what their keys mean, and what is said about broken ones: tests/golden/broken_shots/NAME.shot.json
// with NAME.txt. PENUMBRA_REWRITE_GOLDEN=1 rewrites the expectations.
#include "host/shots/shot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "host/models/model.h"
#include "host/shots/model_shot.h"
#include "tests/golden_text.h"
#include "tests/test_folder.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

const fs::path folder = "tests/golden/broken_shots";
constexpr std::string_view suffix = ".shot.json";

class BrokenShot : public test::InSourceRoot {};

TEST_P(BrokenShot, IsExplained) {
    Diagnostics diagnostics;
    EXPECT_FALSE(read_shot(folder / (GetParam() + std::string(suffix)), diagnostics));
    ASSERT_FALSE(diagnostics.empty());
    test::expect_golden(diagnostics.text(), folder / (GetParam() + ".txt"));
}

INSTANTIATE_TEST_SUITE_P(Golden, BrokenShot, ::testing::ValuesIn(test::names_in(folder, suffix)),
                         [](const auto& instance) { return instance.param; });

// Every prefix of a good shot is an error or a shot, and never a crash.
TEST(Shot, SurvivesTruncation) {
    const std::string text = test::read_text(fs::path(PENUMBRA_SOURCE_DIR) / "scenes/colonnade.shot.json");
    ASSERT_FALSE(text.empty());
    const test::TestFolder made;
    const fs::path file = made / "truncated.shot.json";
    for (size_t length = 0; length + 2 < text.size(); length += 7) {
        std::ofstream(file, std::ios::binary) << text.substr(0, length);
        Diagnostics diagnostics;
        EXPECT_FALSE(read_shot(file, diagnostics)) << length;
        EXPECT_FALSE(diagnostics.empty()) << length;
    }
}

TEST(Shot, ShippedShotsAreGood) {
    int shots = 0;
    for (const fs::directory_entry& entry :
         fs::recursive_directory_iterator(fs::path(PENUMBRA_SOURCE_DIR) / "scenes")) {
        if (!entry.path().filename().string().ends_with(suffix)) continue;
        Diagnostics diagnostics;
        EXPECT_TRUE(read_shot(entry.path(), diagnostics)) << diagnostics.text();
        ++shots;
    }
    EXPECT_GE(shots, 30);
}

Shot two_keys() {
    Shot shot;
    shot.camera = {{.frame = 10, .position = {0, 2, 8}, .target = {0, 1, 0}},
                   {.frame = 20, .position = {2, 2, 8}, .target = {0, 1, 4}}};
    shot.sun = {{.frame = 0, .to_sun = {0, 5, 0}}, {.frame = 10, .to_sun = {1, 0, 0}}};
    return shot;
}

TEST(Shot, KeysAreHeldOutsideAndLinearInside) {
    const Shot shot = two_keys();
    EXPECT_EQ(camera_at(shot, 0, 1).position, camera_at(shot, 10, 1).position);
    EXPECT_EQ(camera_at(shot, 99, 1).position, camera_at(shot, 20, 1).position);
    EXPECT_DOUBLE_EQ(camera_at(shot, 12.5, 1).position[0], 0.5);
}

// Keys of different length must weigh the same: a sun direction is a direction.
TEST(Shot, SunDirectionsAreRenormalised) {
    const SunState sun = sun_at(two_keys(), 5);
    EXPECT_NEAR(glm::length(sun.to_sun), 1, 1e-15);
    EXPECT_NEAR(sun.to_sun.x, std::sqrt(0.5), 1e-15);
    EXPECT_NEAR(sun.to_sun.y, std::sqrt(0.5), 1e-15);
}

TEST(Shot, CameraLooksAtItsTarget) {
    const Shot shot = two_keys();
    for (const double frame : {0.0, 13.0, 20.0}) {
        const Camera camera = camera_at(shot, frame, 16.0 / 9);
        const auto& m = camera.world_from_view;
        // Columns right, up, back are a right-handed orthonormal frame, and the target lies on -back.
        const glm::dvec3 right(m[0], m[1], m[2]), up(m[3], m[4], m[5]), back(m[6], m[7], m[8]);
        EXPECT_NEAR(glm::length(glm::cross(right, up) - back), 0, 1e-14);
        EXPECT_GT(up.y, 0);
        const glm::dvec3 position(camera.position[0], camera.position[1], camera.position[2]);
        const glm::dvec3 target =
            glm::mix(glm::dvec3(0, 1, 0), glm::dvec3(0, 1, 4), std::clamp((frame - 10) / 10, 0.0, 1.0));
        EXPECT_NEAR(glm::length(glm::normalize(target - position) + back), 0, 1e-14);
    }
}

TEST(Shot, OriginMovesTheCameraAlone) {
    Shot shot = two_keys();
    const Camera before = camera_at(shot, 15, 1);
    shot.origin = {1e6, -2, 3};
    const Camera after = camera_at(shot, 15, 1);
    EXPECT_EQ(after.world_from_view, before.world_from_view);
    EXPECT_EQ(after.position[0], before.position[0] + 1e6);
}

TEST(Shot, MovesOnlyWhereSomethingDoes) {
    Shot shot = two_keys();
    EXPECT_TRUE(moves(shot));
    shot.camera.pop_back();
    EXPECT_FALSE(moves(shot));  // the sun's path moves no surface
    shot.objects["gate"].keys = {{.frame = 0}, {.frame = 9, .rotation_deg = {0, 90, 0}}};
    EXPECT_TRUE(moves(shot));
}

TEST(Shot, ObjectsMustNameOneNode) {
    Model model;
    model.nodes = {Node{.name = "gate"}, Node{.name = "twin"}, Node{.name = "twin"},
                   Node{.name = "fixed", .matrix = glm::dmat4(1)}};
    const auto errors = [&](const std::string& name) {
        Shot shot = two_keys();
        shot.objects[name].keys = {{.frame = 0}};
        Diagnostics diagnostics;
        const bool good = check_objects(shot, model, diagnostics);
        EXPECT_EQ(good, diagnostics.empty());
        return diagnostics.text();
    };
    EXPECT_EQ(errors("gate"), "");
    EXPECT_EQ(errors("gaet"), "objects.gaet: the scene has no node named \"gaet\"; did you mean \"gate\"?\n");
    EXPECT_EQ(errors("twin"), "objects.twin: the scene has 2 nodes named \"twin\"\n");
    EXPECT_EQ(errors("fixed"), "");
}

// What is told of a list, and what is looked for, grows with the list and not with its square.
TEST(Shot, ListsAreBounded) {
    const auto said = [](size_t models, size_t lights) {
        std::string list, lamps;
        for (size_t i = 0; i < models; ++i) list += std::string(i ? "," : "") + R"({"file": "a.glb"})";
        for (size_t i = 0; i < lights; ++i)
            lamps += (i ? ",\"" : "\"") + std::to_string(i) +
                     R"(": {"kind": "point", "intensity": 1, "keys": [{"frame": 0, "position": [0, 0, 0]}]})";
        Diagnostics diagnostics;
        const auto shot =
            parse_shot(R"({"penumbra_shot": 1, "scene": [)" + list + R"(], "lights": {)" + lamps +
                           R"(}, "camera": {"keys": [{"frame": 0, "position": [0, 0, 1],
                                         "target": [0, 0, 0]}]}})",
                       "s.shot.json", diagnostics);
        EXPECT_EQ(shot.has_value(), diagnostics.empty());
        return diagnostics.text();
    };
    EXPECT_EQ(said(1, 256), "");
    EXPECT_NE(said(1, 257).find("expected an object of 1 to 256 lights"), std::string::npos);
    EXPECT_NE(said(1025, 1).find("expected a list of 1 to 1024 models"), std::string::npos);
    const std::string same = said(1000, 1);
    EXPECT_EQ(std::ranges::count(same, '\n'), 999) << "one for each of a name that another has";

    Model model;
    Shot shot;
    for (int i = 0; i < 1000; ++i) {
        model.nodes.emplace_back().name = "node" + std::to_string(i);
        shot.objects["mode" + std::to_string(i)];
    }
    Diagnostics diagnostics;
    EXPECT_FALSE(check_objects(shot, model, diagnostics));
    const std::string text = diagnostics.text();
    EXPECT_EQ(diagnostics.size(), 1000u);
    size_t suggested = 0;
    for (size_t at = text.find("mean"); at != text.npos; at = text.find("mean", at + 1)) ++suggested;
    EXPECT_EQ(suggested, 16u);
}

// A shot finds its model again by the way that was written, whatever folder on it is a link, and
// whether or not the shot's own folder is there yet.
TEST(Shot, NamesOfModelsLeadBackToThem) {
    const test::TestFolder root;
    fs::create_directories(root / "far/deep");
    fs::create_directories(root / "models/sets");
    fs::create_directory_symlink(root / "far/deep", root / "link");
    fs::create_directory_symlink(root / "models/sets", root / "sets");
    for (const char* file : {"m.gltf", "far/m.gltf", "models/m.gltf", "models/sets/m.gltf"})
        std::ofstream(root / file) << file;
    fs::create_symlink(root / "far/m.gltf", root / "alias.gltf");
    for (const char* model : {"m.gltf", "far/m.gltf", "sets/m.gltf", "models/m.gltf", "alias.gltf"})
        for (const char* of_shot : {"", "far", "link", "link/new/er", "new", "models/sets", "sets"}) {
            const fs::path shots = root / of_shot, way = seen_from(root / model, shots);
            EXPECT_EQ(way.filename(), fs::path(model).filename());
            EXPECT_TRUE(fs::equivalent(from_folder(shots, way.string()), root / model)) << model << of_shot;
            fs::create_directories(shots);
            EXPECT_TRUE(fs::equivalent(from_folder(shots, way.string()), root / model)) << model << of_shot;
            for (const char* made : {"far/deep/new", "new"}) fs::remove_all(root / made);
        }
    EXPECT_EQ(from_folder("scenes/lights", "../absent.glb"), "scenes/absent.glb") << "as short as it can be";
    fs::remove(root / "far/m.gltf");
    EXPECT_FALSE(fs::exists(from_folder(root / "link", "../m.gltf"))) << "there is another of that name";
}

// 16 distinct offsets that fill one pixel without a bias.
TEST(Jitter, CoversOnePixel) {
    std::set<std::array<double, 2>> seen;
    std::array<double, 2> low{1, 1}, high{-1, -1}, sum{0, 0};
    for (uint32_t frame = 0; frame < 16; ++frame) {
        const auto jitter = halton_jitter(frame, {100, 50});
        EXPECT_EQ(jitter, halton_jitter(frame + 16, {100, 50}));
        seen.insert(jitter);
        const std::array<double, 2> pixels{jitter[0] * 100, jitter[1] * 50};
        for (size_t axis = 0; axis < 2; ++axis) {
            low[axis] = std::min(low[axis], pixels[axis]);
            high[axis] = std::max(high[axis], pixels[axis]);
            sum[axis] += pixels[axis] / 16;
        }
    }
    EXPECT_EQ(seen.size(), 16u);
    for (size_t axis = 0; axis < 2; ++axis) {
        EXPECT_GE(low[axis], -0.5);
        EXPECT_LE(high[axis], 0.5);
        EXPECT_GT(high[axis] - low[axis], 0.85);
        EXPECT_LT(std::abs(sum[axis]), 0.05);
    }
}

}  // namespace
}  // namespace penumbra
