// SPDX-License-Identifier: MIT
// Round silhouettes: spheres that hang, whose umbra may end above the floor, spheres at rest on it, rings.
#include "host/generated/tuning/families.h"
#include "host/generated/tuning/placing.h"

namespace penumbra::tuning {

namespace {

Shape ball(double radius) {
    std::vector<ProfilePoint> profile;
    constexpr int rings = 14;
    for (int i = 1; i < rings; ++i) {
        const double angle = glm::pi<double>() * i / rings;
        profile.push_back({-radius * std::cos(angle), radius * std::sin(angle)});
    }
    return lathe(profile, 28);
}

}  // namespace

void build_spheres(const Setting& setting, Stage& stage) {
    SceneRandom random(setting.seed);
    stage.builder =
        ModelBuilder({{{0.42f, 0.42f, 0.44f, 1}}, {{0.65f, 0.30f, 0.22f, 1}}, {{0.30f, 0.45f, 0.55f, 1}}});
    const double distance = setting.distance_m;
    stage.builder.solid("floor", ground(3 * distance, 3 * distance, 2, 2), 0);
    for (int i = 0; i < 24; ++i) {
        Shape shape = ball(distance * between(0.004, 0.06, random));
        const glm::dvec3 place = caster_place(setting, random);
        if (i < 4)
            stage.add_movable(std::move(shape), 1, place);
        else
            stage.builder.solid("ball_" + std::to_string(i), moved(std::move(shape), glm::dmat4(1), place),
                                1);
    }
    for (int i = 0; i < 8; ++i) {
        const double radius = distance * between(0.006, 0.05, random);
        stage.builder.solid(
            "resting_" + std::to_string(i),
            moved(ball(radius), glm::dmat4(1), floor_point(setting, random) + glm::dvec3(0, radius, 0)), 2);
    }
    for (int i = 0; i < 6; ++i) {
        const double radius = distance * between(0.015, 0.06, random);
        const glm::dmat4 turned = any_rotation(random);
        Shape ring = moved(link(radius, radius * random.in(0.08, 0.3), 0, 40, 12), turned, {});
        const glm::dvec3 place = caster_place(setting, random);
        if (i < 2)
            stage.add_movable(std::move(ring), 2, place);
        else
            stage.builder.solid("ring_" + std::to_string(i), moved(std::move(ring), glm::dmat4(1), place), 2);
    }
}

}  // namespace penumbra::tuning
