// SPDX-License-Identifier: MIT
// Lamps light what rays hit: a wall in a mirror on the floor against closed forms in double precision.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/models/model_builder.h"
#include "host/shots/light_choice.h"
#include "host/truth/light_visibility.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"

namespace penumbra::test {
namespace {

constexpr double exposure = 0.01, wall_z = -3.1;
constexpr std::array<float, 3> base{0.5f, 0.25f, 1};
const std::vector<std::string> without_ambient{"nodes.rays.params.ambient=[0,0,0]"};

class LampsAtHits : public GpuTest {};

ShotLight lamp_at(const glm::dvec3& position, LightKind kind = LightKind::point) {
    ShotLight light;
    light.kind = kind;
    light.keys = {{0, position}};
    return light;
}

struct Room {
    std::vector<Shape> blockers;  // besides the mirror on the floor, the wall and a ceiling; black
    std::map<std::string, ShotLight> lights;
    std::array<uint32_t, 2> size{64, 36};

    Shot shot() const {
        Material mirror, white, black;
        mirror.roughness = 0;
        white.base_color = {base[0], base[1], base[2], 1};
        black.base_color = {0, 0, 0, 1};
        ModelBuilder builder({mirror, white, black});
        builder.solid("floor", ground(4, 3, 1, 1), 0);
        builder.solid("wall", box({-4, 0, wall_z - 0.1}, {4, 6, wall_z}), 1);
        builder.solid("ceiling", box({-9, 6.5, -9}, {9, 6.6, 9}), 2);
        for (const Shape& blocker : blockers) builder.solid("blocker", blocker, 2);
        Shot shot = night_shot(builder.take(), size);
        shot.lights = lights;
        return shot;
    }
};

// A pixel that shows the wall in the mirror.
struct Seen {
    size_t pixel;
    glm::dvec3 point;
};

std::vector<Seen> wall_in_mirror(const Shot& shot) {
    const Camera camera = camera_at(shot, 0, double(shot.size[0]) / shot.size[1]);
    std::vector<Seen> seen;
    for (size_t i = 0; i < size_t{shot.size[0]} * shot.size[1]; ++i) {
        glm::dvec3 origin;
        const glm::dvec3 direction = mirrored(camera, shot.size, i, origin);
        if (!(direction.y > 0) || std::abs(origin.x) > 3.9 || std::abs(origin.z) > 2.9) continue;
        const glm::dvec3 hit = origin + direction * ((wall_z - origin.z) / direction.z);
        if (std::abs(hit.x) < 3.9 && hit.y > 0.02 && hit.y < 5.9) seen.push_back({i, hit});
    }
    EXPECT_GT(seen.size(), 300u);
    return seen;
}

// Lux on the wall of what has no size, without what stands between: as KHR_lights_punctual has it.
double lux_of(const ShotLight& light, const glm::dvec3& point) {
    const glm::dvec3 to = light.keys[0].position - point;
    const double d = glm::length(to), cosine = std::max(to.z / d, 0.0), of_range = d / light.range;
    double lux = light.strength * cosine / (d * d) * std::clamp(1 - std::pow(of_range, 4), 0.0, 1.0);
    if (light.kind == LightKind::spot) {
        const double along = -glm::dot(to / d, glm::normalize(light.keys[0].direction)),
                     outer = std::cos(glm::radians(light.outer_deg)),
                     inner = std::cos(glm::radians(light.inner_deg));
        lux *= std::pow(std::clamp((along - outer) / (inner - outer), 0.0, 1.0), 2);
    }
    return lux;
}

double radiance_of(double lux, size_t channel) {
    return double(base[channel]) * exposure / std::numbers::pi * lux;
}

std::array<std::vector<float>, 3> mirror_of(const Shot& shot) {
    const auto session = open_shipped("raw_reflections", shot, without_ambient);
    session->run_frame(0, true);
    return colors(*session);
}

// Who goes past the lamp finds the floor or the ceiling behind it: the ray has to end at the lamp.
TEST_F(LampsAtHits, APointLightsTheWallThatAMirrorShows) {
    Room room;
    ShotLight& lamp = room.lights["lamp"] = lamp_at({0.5, 1.2, -1.5});
    lamp.color = {1, 0.5, 0.25};
    lamp.strength = 800;
    const Shot shot = room.shot();
    const auto image = mirror_of(shot);
    for (const auto& [pixel, point] : wall_in_mirror(shot))
        for (size_t c = 0; c < 3; ++c) {
            const double expected = radiance_of(lux_of(lamp, point) * lamp.color[int(c)], c);
            ASSERT_NEAR(image[c][pixel], expected, 3e-3 * expected) << pixel;
        }
}

TEST_F(LampsAtHits, ASpotLightsItsConeAlone) {
    Room room;
    ShotLight& lamp = room.lights["lamp"] = lamp_at({0, 2, -1}, LightKind::spot);
    lamp.keys[0].direction = {0.2, -0.4, -1};
    lamp.inner_deg = 12;
    lamp.outer_deg = 25;
    lamp.strength = 2000;
    const Shot shot = room.shot();
    const auto image = mirror_of(shot);
    size_t outside = 0, inside = 0;
    for (const auto& [pixel, point] : wall_in_mirror(shot)) {
        const double expected = radiance_of(lux_of(lamp, point), 0);
        ASSERT_NEAR(image[0][pixel], expected, 5e-3 * expected + 1e-4) << pixel;
        ++(expected > 0 ? inside : outside);
        if (expected == 0) {
            ASSERT_EQ(image[0][pixel], 0) << pixel;
        }
    }
    EXPECT_GT(inside, 60u);
    EXPECT_GT(outside, 60u);
}

TEST_F(LampsAtHits, BeyondItsRangeNothingIsLit) {
    Room room;
    ShotLight& lamp = room.lights["lamp"] = lamp_at({-1, 1, -2});
    lamp.range = 2.5;
    const Shot shot = room.shot();
    const auto image = mirror_of(shot);
    size_t within = 0, beyond = 0;
    for (const auto& [pixel, point] : wall_in_mirror(shot)) {
        const double expected = radiance_of(lux_of(lamp, point), 0);
        ASSERT_NEAR(image[0][pixel], expected, 3e-3 * expected + 1e-5) << pixel;
        ++(expected > 0 ? within : beyond);
        if (expected == 0) {
            ASSERT_EQ(image[0][pixel], 0) << pixel;
        }
    }
    EXPECT_GT(within, 60u);
    EXPECT_GT(beyond, 60u);
}

// Behind the wall, in a box, and off.
TEST_F(LampsAtHits, WhatIsHiddenOrOffLightsNothing) {
    enum class How { behind_the_wall, in_a_box, off, seen };
    for (const How how : {How::behind_the_wall, How::in_a_box, How::off, How::seen}) {
        Room room;
        ShotLight& lamp = room.lights["lamp"] = lamp_at({0, 1, how == How::behind_the_wall ? -4 : -1});
        if (how == How::off) lamp.keys[0].power = 0;
        if (how == How::in_a_box) room.blockers = {box({-0.2, 0.8, -1.2}, {0.2, 1.2, -0.8})};
        const Shot shot = room.shot();
        const auto image = mirror_of(shot);
        for (const auto& [pixel, point] : wall_in_mirror(shot))
            ASSERT_EQ(image[0][pixel] > 0, how == How::seen) << int(how) << ", " << pixel;
    }
}

// Of one colour, whichever is drawn brings the light of all; of several colours the mean does.
TEST_F(LampsAtHits, LampsAddUp) {
    Room room;
    room.lights["a"] = lamp_at({-2, 1.5, -1.5});
    room.lights["b"] = lamp_at({1, 0.8, -2});
    room.lights["b"].strength = 30;
    room.lights["c"] = lamp_at({2.5, 2, -1.2});
    for (const bool colored : {false, true}) {
        if (colored) room.lights["b"].color = {0.1, 2, 4};
        if (colored) room.lights["c"].color = {3, 0.2, 0.5};
        const Shot shot = room.shot();
        const auto session = open_shipped("raw_reflections", shot, without_ambient);
        const uint32_t frames = colored ? 64 : 1;
        const auto seen = wall_in_mirror(shot);
        glm::dvec3 sum(0), squares(0), expected(0);
        for (uint32_t frame = 0; frame < frames; ++frame) {
            session->run_frame(frame, frame == 0);
            const auto image = colors(*session);
            for (const auto& [pixel, point] : seen)
                for (int c = 0; c < 3; ++c) {
                    double all = 0;
                    for (const auto& [name, lamp] : room.lights)
                        all += radiance_of(lamp.color[c] * lux_of(lamp, point), size_t(c));
                    if (!colored) {
                        ASSERT_NEAR(image[size_t(c)][pixel], all, 3e-3 * all) << pixel;
                    }
                    const double relative = double(image[size_t(c)][pixel]) / all;
                    sum[c] += relative;
                    squares[c] += relative * relative;
                    expected[c] += 1;
                }
        }
        for (int c = 0; colored && c < 3; ++c) {
            const double mean = sum[c] / expected[c],
                         deviation = std::sqrt((squares[c] / expected[c] - mean * mean) / expected[c]);
            EXPECT_GT(deviation, 0) << "one is drawn";
            EXPECT_NEAR(mean, 1, 5 * deviation + 1e-3) << c;
        }
    }
}

// Of a lamp with a size, by a fine grid: L cos cos' / d^2 over its area.
double lux_of_area(const ShotLight& light, const glm::dvec3& point) {
    const LightKey& key = light.keys[0];
    const bool round = light.kind == LightKind::disc || light.kind == LightKind::sphere;
    const glm::dvec3 centre = key.position;
    if (light.kind == LightKind::sphere) {
        const glm::dvec3 to = centre - point;
        const double d = glm::length(to);
        return light.strength * std::numbers::pi * light.radius * light.radius * to.z / (d * d * d);
    }
    glm::dvec3 u = glm::normalize(key.along), facing = glm::normalize(key.direction);
    double across = round ? light.radius : light.height / 2, along = round ? light.radius : light.length / 2;
    if (light.kind == LightKind::tube) {
        across = light.radius;
        facing = point - centre;
        facing = glm::normalize(facing - u * glm::dot(u, facing));
    } else if (round) {
        u = glm::normalize(glm::cross(facing, glm::dvec3(0.3, 0.2, 1)));
    }
    const glm::dvec3 v = glm::cross(facing, u);
    constexpr int n = 100;
    double sum = 0;
    for (int i = 0; i < n * n; ++i) {
        const double s = 2 * (i % n + 0.5) / n - 1, t = 2 * (int(i / n) + 0.5) / n - 1;
        if (round && s * s + t * t > 1) continue;
        const glm::dvec3 to = centre + s * along * u + t * across * v - point;
        const double d2 = glm::dot(to, to);
        sum += std::max(to.z, 0.0) * std::max(-glm::dot(to, facing), 0.0) / (d2 * d2);
    }
    return light.strength * sum * 4 * along * across / (n * n);
}

std::vector<ShotLight> large_lamps() {
    std::vector<ShotLight> lamps;
    for (const LightKind kind : {LightKind::sphere, LightKind::disc, LightKind::rectangle, LightKind::tube}) {
        ShotLight lamp = lamp_at({0.3, 2, -0.8}, kind);
        lamp.radius = kind == LightKind::tube ? 0.05 : 0.3;
        lamp.length = 0.8;
        lamp.height = 0.4;
        lamp.keys[0].direction = {0, -0.6, -0.8};
        lamp.keys[0].along = {1, 0, 0};
        lamp.strength = 3000;
        lamps.push_back(lamp);
    }
    return lamps;
}

// Half behind a plate: the truth is what all of it would shine times the share that is seen, which is a
// closed form.
TEST_F(LampsAtHits, TheTruthOfALampWithASizeIsTheClosedForm) {
    for (const ShotLight& lamp : large_lamps()) {
        SCOPED_TRACE(name_of(lamp.kind));
        Room room;
        room.lights["lamp"] = lamp;
        // From above the lamp's middle down to no farther than the mirror's view of the wall.
        const double plate_z = -1.7;
        room.blockers = {box({-9, 1.4, plate_z - 1e-3}, {0.1, 4, plate_z + 1e-3})};
        const Shot shot = room.shot();
        constexpr uint32_t rays = 256;
        const PlanarImage truth = truth_of(shot, "specular", rays);
        const NearLight closed(light_block(lamp, 0, glm::dvec3(0)));
        const std::vector<glm::dvec3> plate{
            {-9, 1.4, plate_z}, {0.1, 1.4, plate_z}, {0.1, 4, plate_z}, {-9, 4, plate_z}};
        double sum = 0, expected_sum = 0;
        size_t partly = 0, all = 0;
        for (const auto& [pixel, point] : wall_in_mirror(shot)) {
            if (point.y > 0.9) continue;  // below the plate's reflection
            const double share = closed.visibility(point, plate),
                         expected = radiance_of(lux_of_area(lamp, point) * share, 0),
                         whole = radiance_of(lux_of_area(lamp, point), 0);
            const double seen = double(truth.planes[0].values[pixel]) - double(base[0]) * 0.16;
            const double noise = whole * std::sqrt(share * (1 - share) / rays);
            ASSERT_NEAR(seen, expected, 6 * noise + 0.012 * whole) << pixel;
            if (share > 0.02 && share < 0.98) ++partly;
            ++all;
            sum += seen;
            expected_sum += expected;
        }
        EXPECT_GT(partly, 15u);
        EXPECT_GT(all, 100u);
        EXPECT_NEAR(sum / expected_sum, 1, 0.01);
    }
}

// Lamps that are off are tested and drawn of none; nothing of the picture may be another for it.
TEST_F(LampsAtHits, LampsThatAreOffChangeNoBit) {
    Room room;
    Shot shot = room.shot();
    shot.environment = linear_sky(0.2, 2);
    shot.frames = 3;
    Shot with_lamps = shot;
    with_lamps.lights["a"] = lamp_at({0, 1, -1});
    with_lamps.lights["a"].keys[0].power = 0;
    for (const char* pipeline : {"reflections", "lit"}) {
        const auto without = open_shipped(pipeline, shot), off = open_shipped(pipeline, with_lamps);
        EXPECT_EQ(std::ranges::count(without->plan().slots, "lights", &HostSlot::name), 0);
        EXPECT_EQ(std::ranges::count(off->plan().slots, "lights", &HostSlot::name), 1);
        for (uint32_t frame = 0; frame < 3; ++frame) {
            without->run_frame(frame, frame == 0);
            off->run_frame(frame, frame == 0);
            EXPECT_TRUE(colors(*without) == colors(*off)) << pipeline << ", frame " << frame;
        }
    }
}

}  // namespace
}  // namespace penumbra::test
