// SPDX-License-Identifier: MIT
// Closed forms of lights that are near: known shares, and against many points of the light itself. And what a
// shot may say of lights.
#include "host/truth/light_visibility.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <glm/gtc/constants.hpp>

#include "host/shots/light_choice.h"
#include "host/truth/sun_visibility.h"
#include "tests/test_folder.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

ShotLight light_of(LightKind kind) {
    ShotLight light;
    light.kind = kind;
    light.radius = kind == LightKind::tube ? 0.1 : 0.5;
    light.length = kind == LightKind::rectangle ? 1.4 : 2;
    light.height = 0.6;
    light.keys = {{0, {0.2, 3, -0.1}, {0.1, -1, 0.2}, {1, 0.3, 0.2}, 1, 1}};
    return light;
}

constexpr LightKind all_kinds[] = {LightKind::point,     LightKind::sphere, LightKind::disc,
                                   LightKind::rectangle, LightKind::tube,   LightKind::spot};

TEST(LightVisibility, SharesOfADiscAndASquareAreKnown) {
    const double far = 100;
    const std::vector<glm::dvec2> right{{0.5, -far}, {far, -far}, {far, far}, {0.5, far}};
    const double segment = std::acos(0.5) - 0.5 * std::sqrt(0.75);
    EXPECT_NEAR(disc_share(right), segment / glm::pi<double>(), 1e-12);
    EXPECT_NEAR(square_share(right), 0.25, 1e-12);
    const std::vector<glm::dvec2> all{{-far, -far}, {far, -far}, {far, far}, {-far, far}};
    EXPECT_NEAR(disc_share(all), 1, 1e-12);
    EXPECT_NEAR(square_share(all), 1, 1e-12);
    const std::vector<glm::dvec2> inner{{0, 0}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}},
        beside{{2, 0}, {3, 0}, {3, 1}};
    EXPECT_NEAR(disc_share(inner), 0.25 / glm::pi<double>(), 1e-12);
    EXPECT_NEAR(square_share(inner), 1.0 / 16, 1e-12);
    EXPECT_NEAR(disc_share(beside), 0, 1e-12);
    EXPECT_NEAR(square_share(beside), 0, 1e-12);
}

// The share of the light's own points whose segment to the receiver misses the blocker.
TEST(LightVisibility, IsTheShareOfPointsThatAreSeen) {
    const std::vector<glm::dvec3> blocker{
        {-0.4, 1.1, -0.6}, {0.35, 1.2, -0.5}, {0.3, 1.3, 0.5}, {-0.5, 1.2, 0.4}};
    const glm::dvec3 n = glm::cross(blocker[1] - blocker[0], blocker[2] - blocker[0]);
    for (const LightKind kind : all_kinds) {
        const NearLight light(light_block(light_of(kind), 0, glm::dvec3(0)));
        size_t partly = 0;
        for (int i = 0; i < 40; ++i) {
            const glm::dvec3 receiver(-1.3 + 0.06 * i, 0, 0.02 * i - 0.5);
            ASSERT_TRUE(light.reaches(receiver));
            constexpr int side = 200;
            int seen = 0;
            for (int k = 0; k < side * side; ++k) {
                const glm::dvec2 u((k % side + 0.5) / side, (k / side + 0.5) / side);
                const glm::dvec3 way = light.target(receiver, u) - receiver;
                bool inside =
                    true;  // the blocker is flat within the eye's reach only: test its cone of edges
                double sign = 0;
                for (size_t e = 0; e < 4; ++e) {
                    const double side_of =
                        glm::dot(way, glm::cross(blocker[e] - receiver, blocker[(e + 1) % 4] - receiver));
                    if (sign == 0) sign = side_of;
                    inside = inside && side_of * sign > 0;
                }
                seen += !inside;
            }
            const double counted = double(seen) / (side * side), exact = light.visibility(receiver, blocker);
            EXPECT_NEAR(exact, counted, 2e-3) << name_of(kind) << " from " << receiver.x;
            partly += exact > 0.01 && exact < 0.99;
        }
        EXPECT_GT(partly, 3u) << name_of(kind);
        EXPECT_GT(glm::length(n), 0);
    }
}

TEST(LightVisibility, OfASphereIsTheCapsHalfPlane) {
    ShotLight ball = light_of(LightKind::sphere);
    const NearLight light(light_block(ball, 0, glm::dvec3(0)));
    const glm::dvec3 receiver(0), centre(0.2, 3, -0.1);
    const double radius = std::asin(0.5 / glm::length(centre));
    for (const double x : {-0.2, -0.05, 0.0, 0.1, 0.25}) {
        const std::vector<glm::dvec3> wall{{x, 1, -50}, {60, 1, -50}, {60, 1, 50}, {x, 1, 50}};
        const glm::dvec3 edge = glm::normalize(glm::cross(glm::dvec3(0, 0, 1), glm::dvec3(x, 1, 0)));
        const double off = std::asin(glm::dot(edge, glm::normalize(centre)));
        EXPECT_NEAR(light.visibility(receiver, wall), half_plane_visibility(off, radius), 1e-6) << x;
    }
}

TEST(LightVisibility, ReachesWhatIsInRangeBeforeItAndInItsCone) {
    ShotLight spot = light_of(LightKind::spot);
    spot.outer_deg = 20;
    spot.range = 5;
    spot.keys[0].direction = {0, -1, 0};
    const NearLight light(light_block(spot, 0, glm::dvec3(0)));
    const glm::dvec3 below(0.2, 0, -0.1);
    EXPECT_TRUE(light.reaches(below));
    EXPECT_FALSE(light.reaches(below + glm::dvec3(1.2, 0, 0)));  // 21.8 degrees
    EXPECT_TRUE(light.reaches(below + glm::dvec3(1.0, 0, 0)));
    EXPECT_FALSE(light.reaches(below - glm::dvec3(0, 2.1, 0)));
    EXPECT_FALSE(light.reaches({0.2, 2.9, -0.1}));  // inside it
    spot.keys[0].power = 0;
    EXPECT_FALSE(NearLight(light_block(spot, 0, glm::dvec3(0))).reaches(below));
    const NearLight panel(light_block(light_of(LightKind::rectangle), 0, glm::dvec3(0)));
    EXPECT_TRUE(panel.reaches(below));
    EXPECT_FALSE(panel.reaches({0.2, 6, -0.1}));
    ShotLight flush = light_of(LightKind::rectangle);
    flush.keys[0] = {0, {0, 2, 0}, {0, -1, 0}, {1, 0, 0}, 1, 1};
    const NearLight in_the_ceiling(light_block(flush, 0, glm::dvec3(0)));
    for (const double above : {-1e-6, 0., 1e-6})
        EXPECT_FALSE(in_the_ceiling.reaches({3, 2 + above, 1})) << "the ceiling itself";
    EXPECT_TRUE(in_the_ceiling.reaches({3, 1.999, 1}));
    ShotLight bulb = light_of(LightKind::sphere);
    bulb.keys[0].direction = {0, -1, 0};
    const glm::dvec3 centre = bulb.keys[0].position;
    EXPECT_TRUE(NearLight(light_block(bulb, 0, glm::dvec3(0))).reaches(centre + glm::dvec3(0, 1, 0)))
        << "straight behind its direction";
}

std::string errors_of(const std::string& lights) {
    const test::TestFolder folder;
    const fs::path file = folder / "lights.shot.json";
    std::ofstream(file) << R"({ "penumbra_shot": 1, "scene": "a.glb", "frames": 4,
  "camera": { "keys": [{ "frame": 0, "position": [0, 0, 5], "target": [0, 0, 0] }] }, "lights": )"
                        << lights << "}";
    Diagnostics diagnostics;
    const auto shot = read_shot(file, diagnostics);
    EXPECT_EQ(shot.has_value(), diagnostics.empty());
    return diagnostics.text();
}

TEST(ShotLights, AreReadAndTheirMistakesNamed) {
    EXPECT_EQ(
        errors_of(
            R"({ "lamp": { "kind": "point", "intensity": 5, "keys": [{ "frame": 0, "position": [0, 1, 0] }] } })"),
        "");
    const auto expect = [](const std::string& lights, const std::string& said) {
        EXPECT_NE(errors_of(lights).find(said), std::string::npos) << lights << "\n" << errors_of(lights);
    };
    const std::string keys = R"("keys": [{ "frame": 0, "position": [0, 1, 0] }])";
    expect("{}", "expected an object of 1 to 256 lights");
    expect(R"({ "a": { "kind": "rectangel", )" + keys + "} }", "did you mean \"rectangle\"?");
    expect(R"({ "a": { "kind": "disc", "luminance": 5, )" + keys + "} }", "\"radius\" is missing");
    expect(R"({ "a": { "kind": "disc", "radius": 1, "intensity": 5, )" + keys + "} }",
           "lights.a.intensity: unknown key");
    expect(R"({ "a": { "kind": "spot", "intensity": 5, "inner_deg": 30, "outer_deg": 20, )" + keys + "} }",
           "is not below outer_deg");
    expect(R"({ "a": { "kind": "point", "intensity": -5, )" + keys + "} }", "is not in 0 ..");
    expect(R"({ "sun": { "kind": "point", "intensity": 5, )" + keys + "} }", "the sun has a key of its own");
    expect(
        R"({ "a": { "kind": "point", "intensity": 5, "keys": [{ "frame": 0, "position": [0, 1, 0], "direction": [0, 1, 0] }] } })",
        "a point has none");
    expect(
        R"({ "a": { "kind": "rectangle", "width": 1, "height": 1, "luminance": 5, "keys": [{ "frame": 0, "position": [0, 1, 0], "direction": [1, 0, 0] }] } })",
        "`along` is along `direction`");
}

TEST(ShotLights, MoveSwitchAndChangeTheirSizeByKeys) {
    ShotLight lamp = light_of(LightKind::sphere);
    EXPECT_FALSE(light_moves(lamp));
    lamp.keys = {{0, {0, 2, 0}}, {4, {2, 2, 0}}};
    lamp.keys[1].size = 3;
    lamp.keys[1].power = 0;
    EXPECT_TRUE(light_moves(lamp));
    const blocks::Light half = light_block(lamp, 2, {0.5, 0, 0}), off = light_block(lamp, 9, {0, 0, 0});
    EXPECT_FLOAT_EQ(half.centre.v[0], 0.5f);
    EXPECT_FLOAT_EQ(half.u.v[0], 1.0f);
    EXPECT_EQ(half.on, 1u);
    EXPECT_EQ(off.on, 0u);
}

TEST(ShotLights, AMaskIsOfOneOfThem) {
    Shot shot;
    shot.lights["bulb"] = light_of(LightKind::point);
    Diagnostics diagnostics;
    EXPECT_FALSE(choose_light(shot, "", diagnostics));
    EXPECT_NE(diagnostics.text().find("sun, bulb"), std::string::npos);
    EXPECT_EQ(choose_light(shot, "sun", diagnostics)->light, nullptr);
    EXPECT_NE(choose_light(shot, "bulb", diagnostics)->light, nullptr);
    // A pipeline knows which it means, where there is one such only.
    EXPECT_EQ(choose_light(shot, "", diagnostics, LightsFor::sun)->name, "sun");
    EXPECT_EQ(choose_light(shot, "", diagnostics, LightsFor::near)->name, "bulb");
    EXPECT_FALSE(choose_light(shot, "bulp", diagnostics));
    EXPECT_NE(diagnostics.text().find("did you mean \"bulb\"?"), std::string::npos);
    shot.has_sun = false;
    EXPECT_EQ(choose_light(shot, "", diagnostics)->name, "bulb");
}

}  // namespace
}  // namespace penumbra
