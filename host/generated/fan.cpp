// SPDX-License-Identifier: MIT
// Dimensions in metres. The wall stands at z = -3 with a round opening of 1.25 m radius; the sun shines
// through it.
#include "host/generated/fan.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "host/models/model_builder.h"

namespace penumbra {

namespace {

enum MaterialIndex { concrete, plaster, metal, timber };

constexpr double wall_z = -3, wall_thick = 0.25, hub_y = 2.1, opening = 1.25;

// A blade along +x that twists and widens, closed: `pitch` in radians at the root.
Shape blade(double root, double tip, double width, double thickness, double pitch) {
    Shape shape;
    constexpr int sections = 10;
    for (int i = 0; i <= sections; ++i) {
        const double t = double(i) / sections, turn = pitch * (1 - 0.55 * t);
        const double chord = width * (0.55 + 0.45 * std::sin(glm::pi<double>() * (0.15 + 0.7 * t)));
        for (const glm::dvec2 corner : {glm::dvec2(-0.5, -0.5), {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}) {
            const double across = corner.x * chord, up = corner.y * thickness;
            shape.positions.emplace_back(glm::mix(root, tip, t),
                                         std::cos(turn) * across - std::sin(turn) * up,
                                         std::sin(turn) * across + std::cos(turn) * up);
        }
    }
    const auto quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
        shape.indices.insert(shape.indices.end(), {a, b, c, a, c, d});
    };
    for (uint32_t i = 0; i < sections; ++i)
        for (uint32_t k = 0; k < 4; ++k)
            quad(4 * i + k, 4 * i + (k + 1) % 4, 4 * i + 4 + (k + 1) % 4, 4 * i + 4 + k);
    quad(0, 3, 2, 1);
    quad(4 * sections, 4 * sections + 1, 4 * sections + 2, 4 * sections + 3);
    return shape;
}

// Blades about the z axis round a hub.
Shape rotor(int blades, double radius, double width, double pitch) {
    Shape shape = rod({0, 0, -0.11}, {0, 0, 0.11}, 0.16, 32);
    for (int i = 0; i < blades; ++i) {
        Shape one = blade(0.12, radius, width, 0.016, pitch);
        one.transform(glm::rotate(glm::dmat4(1), glm::two_pi<double>() * i / blades, glm::dvec3(0, 0, 1)));
        shape.append(one);
    }
    return shape;
}

// A wall in the x-y plane with a round hole about (0, hub_y): a ring of quads from the circle to the
// rectangle.
Shape wall_with_opening(double half_x, double top) {
    Shape shape;
    constexpr uint32_t segments = 96;
    for (uint32_t i = 0; i < segments; ++i) {
        const double angle = glm::two_pi<double>() * (i + 0.5) / segments;
        const glm::dvec2 d(std::cos(angle), std::sin(angle));
        const double to_side = half_x / std::abs(d.x),
                     to_end = (d.y > 0 ? top - hub_y : hub_y) / std::abs(d.y);
        const glm::dvec2 outer = d * std::min(to_side, to_end);
        for (const double z : {wall_z - wall_thick, wall_z}) {
            shape.positions.emplace_back(opening * d.x, hub_y + opening * d.y, z);
            shape.positions.emplace_back(outer.x, hub_y + outer.y, z);
        }
    }
    // The rectangle's corners fall between two rays: moving the nearest outer point there keeps them sharp.
    for (const glm::dvec2 corner : {glm::dvec2(half_x, top), {-half_x, top}, {half_x, 0}, {-half_x, 0}}) {
        size_t nearest = 1;
        for (size_t i = 1; i < shape.positions.size(); i += 4)
            if (glm::distance(glm::dvec2(shape.positions[i]), corner) <
                glm::distance(glm::dvec2(shape.positions[nearest]), corner))
                nearest = i;
        for (const size_t i : {nearest, nearest + 2}) {
            shape.positions[i].x = static_cast<float>(corner.x);
            shape.positions[i].y = static_cast<float>(corner.y);
        }
    }
    const auto quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
        shape.indices.insert(shape.indices.end(), {a, b, c, a, c, d});
    };
    for (uint32_t i = 0; i < segments; ++i) {
        const uint32_t a = 4 * i,
                       b = 4 * ((i + 1) %
                                segments);  // + 0 inner back, 1 outer back, 2 inner front, 3 outer front
        quad(a + 2, a + 3, b + 3, b + 2);
        quad(a, b, b + 1, a + 1);
        quad(a, a + 2, b + 2, b);
        quad(a + 1, b + 1, b + 3, a + 3);
    }
    return shape;
}

// A wire guard before the opening: rings and spokes.
Shape guard() {
    Shape shape;
    for (const double radius : {0.3, 0.6, 0.9, 1.2}) {
        Shape ring = link(radius, 0.006, 0, 64, 6);
        ring.transform(glm::translate(glm::dmat4(1), glm::dvec3(0, hub_y, wall_z - wall_thick - 0.02)));
        shape.append(ring);
    }
    for (int i = 0; i < 8; ++i) {
        const double angle = glm::two_pi<double>() * i / 8;
        const glm::dvec3 d(std::cos(angle), std::sin(angle), 0), centre(0, hub_y, wall_z - wall_thick - 0.02);
        shape.append(rod(centre + 0.28 * d, centre + opening * 1.02 * d, 0.007, 6));
    }
    return shape;
}

}  // namespace

Model make_fan() {
    ModelBuilder builder({{{0.33f, 0.32f, 0.31f, 1}},
                          {{0.66f, 0.60f, 0.50f, 1}},
                          {{0.30f, 0.33f, 0.36f, 1}},
                          {{0.42f, 0.29f, 0.17f, 1}}});
    builder.solid("floor", ground(8, 8, 16, 16), concrete);
    builder.solid("wall", wall_with_opening(4.5, 4.4), plaster);
    builder.solid("guard", guard(), metal);
    // The axle's bar keeps the rotor in the middle of the wall.
    builder.solid(
        "bearer",
        box({-opening - 0.05, hub_y - 0.04, wall_z - 0.03}, {opening + 0.05, hub_y + 0.04, wall_z + 0.01}),
        metal);
    builder.node("fan_wall", builder.mesh(rotor(5, 1.12, 0.42, 0.6), metal), {0, hub_y, wall_z - 0.15});

    // The pergola, with slats above its fan.
    constexpr double left = -4.2, right = -1.2, back = -0.6, front = 2.4, roof = 2.9;
    Shape frame;
    for (const double x : {left, right})
        for (const double z : {back, front})
            frame.append(box({x - 0.06, 0, z - 0.06}, {x + 0.06, roof, z + 0.06}));
    for (const double z : {back, front})
        frame.append(box({left - 0.3, roof, z - 0.05}, {right + 0.3, roof + 0.14, z + 0.05}));
    for (double x = left; x <= right; x += 0.5)
        frame.append(box({x - 0.02, roof + 0.14, back - 0.3}, {x + 0.02, roof + 0.22, front + 0.3}));
    const glm::dvec3 middle(0.5 * (left + right), roof, 0.5 * (back + front));
    frame.append(box({left, roof + 0.02, middle.z - 0.04}, {right, roof + 0.1, middle.z + 0.04}));
    frame.append(rod(middle - glm::dvec3(0, 0.5, 0), middle + glm::dvec3(0, 0.05, 0), 0.025, 16));
    builder.solid("pergola", std::move(frame), timber);

    Shape flat = rotor(4, 1.15, 0.2, 0.35);
    flat.transform(glm::rotate(glm::dmat4(1), -glm::half_pi<double>(), glm::dvec3(1, 0, 0)));
    builder.node("fan_ceiling", builder.mesh(std::move(flat), metal), middle - glm::dvec3(0, 0.5, 0));

    // Something to shade.
    builder.solid("block_0", box({1.2, 0, -0.4}, {2.2, 0.35, 0.8}), plaster);
    builder.solid("block_1", box({1.6, 0.35, -0.1}, {2.2, 0.7, 0.5}), plaster);
    return builder.take();
}

}  // namespace penumbra
