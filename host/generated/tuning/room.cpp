// SPDX-License-Identifier: MIT
// A room with a window: most of it is dark for certain, and what is not lies behind muntins, blinds and
// furniture at several ways from the light. Built with the sun above +x and turned to where it stands.
#include <algorithm>

#include "host/generated/tuning/families.h"
#include "host/generated/tuning/placing.h"

namespace penumbra::tuning {

namespace {

enum MaterialIndex { floor_wood, plaster, timber, cloth };

constexpr double thick = 0.12;

struct Opening {
    double low, high, half_width;
};

// Four pieces about the opening, in the plane x.
Shape wall_with(const Opening& window, double x, double half_width, double ceiling) {
    Shape shape = box({x, 0, -half_width}, {x + thick, window.low, half_width});
    shape.append(box({x, window.high, -half_width}, {x + thick, ceiling, half_width}));
    for (const double side : {-1.0, 1.0}) {
        const double a = side * window.half_width, b = side * half_width;
        shape.append(box({x, window.low, std::min(a, b)}, {x + thick, window.high, std::max(a, b)}));
    }
    return shape;
}

Shape muntins(const Opening& window, double x, int columns, int rows, double half_bar) {
    Shape shape;
    for (int i = 1; i < columns; ++i) {
        const double z = window.half_width * (2.0 * i / columns - 1);
        shape.append(box({x + 0.04, window.low, z - half_bar}, {x + 0.08, window.high, z + half_bar}));
    }
    for (int i = 1; i < rows; ++i) {
        const double y = glm::mix(window.low, window.high, double(i) / rows);
        shape.append(
            box({x + 0.045, y - half_bar, -window.half_width}, {x + 0.075, y + half_bar, window.half_width}));
    }
    return shape;
}

// Slats over one half of the window.
Shape blinds(const Opening& window, double x, double pitch, double tilt) {
    Shape shape;
    for (double y = window.low + 0.5 * pitch; y < window.high; y += pitch)
        shape.append(moved(bar({0.4 * pitch, 0.002, 0.48 * window.half_width}),
                           glm::rotate(glm::dmat4(1), tilt, glm::dvec3(0, 0, 1)),
                           {x - 0.6 * pitch, y, 0.5 * window.half_width}));
    return shape;
}

Shape table(double half_x, double half_z, double height) {
    Shape shape = box({-half_x, height - 0.03, -half_z}, {half_x, height, half_z});
    for (const double x : {-0.9, 0.9})
        for (const double z : {-0.9, 0.9})
            shape.append(box({x * half_x - 0.02, 0, z * half_z - 0.02},
                             {x * half_x + 0.02, height - 0.03, z * half_z + 0.02}));
    return shape;
}

Shape chair() {
    Shape shape = table(0.2, 0.2, 0.42);
    for (int i = 0; i < 4; ++i)
        shape.append(rod({-0.18, 0.42, -0.17 + 0.113 * i}, {-0.2, 0.85, -0.17 + 0.113 * i}, 0.012, 8));
    shape.append(box({-0.22, 0.85, -0.2}, {-0.18, 0.92, 0.2}));
    return shape;
}

}  // namespace

void build_room(const Setting& setting, Stage& stage) {
    SceneRandom random(setting.seed);
    stage.builder = ModelBuilder({{{0.45f, 0.34f, 0.24f, 1}},
                                  {{0.70f, 0.68f, 0.64f, 1}},
                                  {{0.35f, 0.22f, 0.13f, 1}},
                                  {{0.30f, 0.35f, 0.50f, 1}}});
    const double distance = setting.distance_m;
    const glm::dvec3 level(setting.to_sun.x, 0, setting.to_sun.z);
    const glm::dmat4 to_world = heading(std::atan2(-level.z, level.x));
    const auto turned = [&](Shape shape) { return moved(std::move(shape), to_world, {}); };
    const auto place = [&](const glm::dvec3& p) { return glm::dvec3(to_world * glm::dvec4(p, 1)); };

    // The light through the window's middle falls on the middle of what is looked at.
    const double x = setting.caster_m * glm::length(level), middle = setting.caster_m * setting.to_sun.y;
    const double half_z = 1.3 * distance, back = -1.3 * distance,
                 ceiling = std::max(2 * middle, 0.8 * distance);
    const double half_height = std::min(0.18 * distance, 0.85 * middle);
    const Opening window{middle - half_height, middle + half_height, 0.28 * distance};
    stage.builder.solid("floor",
                        turned(moved(bar({0.5 * (x - back) + 1, 0.1, half_z + 1}), glm::dmat4(1),
                                     {0.5 * (x + back), -0.1, 0})),
                        floor_wood);
    stage.builder.solid("ceiling",
                        turned(moved(bar({0.5 * (x - back) + 1, 0.1, half_z + 1}), glm::dmat4(1),
                                     {0.5 * (x + back), ceiling + 0.1, 0})),
                        plaster);
    stage.builder.solid("wall_window", turned(wall_with(window, x, half_z + 1, ceiling)), plaster);
    stage.builder.solid("wall_back", turned(box({back - thick, 0, -half_z - 1}, {back, ceiling, half_z + 1})),
                        plaster);
    for (const double side : {-1.0, 1.0})
        stage.builder.solid(side < 0 ? "wall_left" : "wall_right",
                            turned(moved(bar({0.5 * (x - back), 0.5 * ceiling, 0.5 * thick}), glm::dmat4(1),
                                         {0.5 * (x + back), 0.5 * ceiling, side * (half_z + 0.5 * thick)})),
                            plaster);
    const double bars = distance * random.in(0.002, 0.006);
    const int rows = static_cast<int>(random.in(2, 5)), columns = static_cast<int>(random.in(3, 7));
    stage.builder.solid("muntins", turned(muntins(window, x, columns, rows, bars)), timber);
    const double tilt = random.in(-0.6, 0.6);
    stage.builder.solid("blinds", turned(blinds(window, x, distance * between(0.006, 0.02, random), tilt)),
                        cloth);

    // Furniture stands where the light falls.
    const glm::dvec3 light{random.in(-0.4, 0.1), 0, random.in(-0.5, 0.5)};  // braces: in this order
    stage.builder.solid("table", turned(moved(table(0.45, 0.3, 0.7), heading(random.in(-0.5, 0.5)), light)),
                        timber);
    for (int i = 0; i < 2; ++i) {
        const glm::dvec3 where{random.in(-0.8, 0.8), 0, random.in(-1.0, 1.0)};
        stage.add_movable(moved(chair(), heading(random.in(0, glm::two_pi<double>())), {}), timber,
                          place(where));
    }
    // A mobile in the beam: it turns where the rest stands.
    for (int i = 0; i < 4; ++i) {
        const double way = setting.caster_m * random.in(0.15, 0.85);
        const double along = random.in(-0.8, 0.8);
        const glm::dvec3 receiver(random.in(-0.2, 0.2), 0, along);
        const glm::dvec3 to_sun(glm::length(level), setting.to_sun.y, 0);
        stage.add_movable(moved(bar({0.1, 0.004, 0.03}), any_rotation(random), {}), cloth,
                          place(receiver + way * to_sun));
    }
}

}  // namespace penumbra::tuning
