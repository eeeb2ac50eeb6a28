// SPDX-License-Identifier: MIT
// Repeated edges, apart by less or more than their penumbrae: fences that stand on the floor, so that each
// bar's penumbra grows from nothing, and lattices that hang.
#include <algorithm>

#include "host/generated/tuning/families.h"
#include "host/generated/tuning/placing.h"

namespace penumbra::tuning {

namespace {

// Upright bars along x, between two rails.
Shape fence(double half_width, double height, double pitch, double half_bar, bool round) {
    Shape shape;
    const int bars = std::min(static_cast<int>(2 * half_width / pitch), 80);
    for (int i = 0; i <= bars; ++i) {
        const double x = (i - 0.5 * bars) * pitch;
        shape.append(round ? rod({x, 0, 0}, {x, height, 0}, half_bar, 10)
                           : box({x - half_bar, 0, -half_bar}, {x + half_bar, height, half_bar}));
    }
    for (const double y : {0.15 * height, 0.9 * height})
        shape.append(
            moved(bar({0.5 * bars * pitch, 1.3 * half_bar, 0.6 * half_bar}), glm::dmat4(1), {0, y, 0}));
    return shape;
}

// Crossed bars in the plane x-z, about the origin.
Shape lattice(double half_size, double pitch, double half_bar) {
    Shape shape;
    const int bars = std::min(static_cast<int>(2 * half_size / pitch), 40);
    for (int i = 0; i <= bars; ++i) {
        const double at = (i - 0.5 * bars) * pitch, end = 0.5 * bars * pitch + half_bar;
        shape.append(box({at - half_bar, 0, -end}, {at + half_bar, half_bar, end}));
        shape.append(rod({-end, -half_bar, at}, {end, -half_bar, at}, 0.7 * half_bar, 8));
    }
    return shape;
}

}  // namespace

void build_fences(const Setting& setting, Stage& stage) {
    SceneRandom random(setting.seed);
    stage.builder =
        ModelBuilder({{{0.45f, 0.43f, 0.38f, 1}}, {{0.38f, 0.24f, 0.14f, 1}}, {{0.16f, 0.17f, 0.19f, 1}}});
    const double distance = setting.distance_m;
    stage.builder.solid("floor", ground(3 * distance, 3 * distance, 2, 2), 0);
    // As high as its top's way to the floor wants, but for fences like walls or like kerbs.
    const double height =
        std::clamp(1.5 * setting.caster_m * setting.to_sun.y, 0.02 * distance, 0.4 * distance);
    for (int i = 0; i < 3; ++i) {
        const double pitch = distance * between(0.006, 0.04, random);
        const glm::dvec3 place = floor_point(setting, random);
        const glm::dmat4 turned = heading(random.in(0, glm::pi<double>()));
        const double half_bar = pitch * random.in(0.06, 0.3), high = height * random.in(0.6, 1.2);
        stage.builder.solid(
            "fence_" + std::to_string(i),
            moved(fence(distance * random.in(0.15, 0.4), high, pitch, half_bar, i == 1), turned, place), 1);
    }
    for (int i = 0; i < 4; ++i) {
        const double pitch = distance * between(0.006, 0.05, random);
        const glm::dmat4 turned = heading(random.in(0, glm::pi<double>()));
        const double half_bar = pitch * random.in(0.06, 0.25);
        Shape shape = moved(lattice(distance * random.in(0.06, 0.16), pitch, half_bar), turned, {});
        const glm::dvec3 place = caster_place(setting, random);
        if (i < 2)
            stage.add_movable(std::move(shape), 2, place);
        else
            stage.builder.solid("lattice_" + std::to_string(i), moved(std::move(shape), glm::dmat4(1), place),
                                2);
    }
}

}  // namespace penumbra::tuning
