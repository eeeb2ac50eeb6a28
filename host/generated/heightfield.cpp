// SPDX-License-Identifier: MIT
// Dimensions in metres. The hills sink below the plain before their border, so that the two simply overlap.
#include "host/generated/heightfield.h"

#include <array>
#include <glm/gtc/matrix_transform.hpp>

#include "host/generated/noise.h"
#include "host/models/model_builder.h"

namespace penumbra {

namespace {

constexpr double half_size = 500;
constexpr int cells = 80;
constexpr double plain_half = 4000;

enum MaterialIndex { grass, earth, steel, brick };

double height(double x, double z) {
    const double edge = glm::smoothstep(0.0, 140.0, half_size - std::max(std::abs(x), std::abs(z)));
    // A valley along x keeps the power line's way open.
    const double valley = 0.25 + 0.75 * glm::smoothstep(25.0, 190.0, std::abs(z + 0.12 * x));
    return glm::mix(-12.0, 26 + 62 * valley * fractal_noise(x / 210, z / 210, 4, 0.38, 11), edge);
}

Shape hills() {
    Shape shape = ground(half_size, half_size, cells, cells);
    for (glm::vec3& p : shape.positions) p.y = static_cast<float>(height(p.x, p.z));
    return shape;
}

constexpr double pylon_height = 26;
constexpr std::array<double, 3> arms{17, 20.5, 24};
constexpr double arm_half = 4.2;

// Four legs that lean together, cross bars and three arms.
Shape pylon() {
    Shape shape;
    const auto leg = [](double y, double sx, double sz) {
        const double spread = 2.6 * (1 - y / pylon_height) + 0.15;
        return glm::dvec3(sx * spread, y, sz * spread);
    };
    constexpr std::array<glm::dvec2, 4> corners{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
    for (size_t i = 0; i < 4; ++i) {
        const glm::dvec2 here = corners[i], next = corners[(i + 1) % 4];
        shape.append(rod(leg(-2, here.x, here.y), leg(pylon_height, here.x, here.y), 0.11, 6));
        for (double y = 0; y < pylon_height - 3; y += 3.2) {
            shape.append(rod(leg(y, here.x, here.y), leg(y + 3.2, next.x, next.y), 0.05, 4));
            shape.append(rod(leg(y, next.x, next.y), leg(y + 3.2, here.x, here.y), 0.05, 4));
        }
    }
    for (const double y : arms) shape.append(rod({0, y, -arm_half}, {0, y, arm_half}, 0.12, 6));
    return shape;
}

// A wire of straight pieces that sags between two points.
Shape wire(const glm::dvec3& a, const glm::dvec3& b, double sag) {
    Shape shape;
    constexpr int pieces = 12;
    const auto at = [&](double t) { return glm::mix(a, b, t) - glm::dvec3(0, 4 * sag * t * (1 - t), 0); };
    for (int i = 0; i < pieces; ++i)
        shape.append(rod(at(double(i) / pieces), at(double(i + 1) / pieces), 0.02, 5));
    return shape;
}

Shape barn() {
    Shape shape = box({-9, -3, -5}, {9, 6, 5});
    shape.append(box({-9.6, 6, -5.6}, {9.6, 6.7, 5.6}));
    shape.append(box({5, 6.7, -1}, {6.4, 10, 0.4}));
    return shape;
}

}  // namespace

Model make_heightfield() {
    ModelBuilder builder({{{0.36f, 0.40f, 0.22f, 1}},
                          {{0.45f, 0.40f, 0.30f, 1}},
                          {{0.35f, 0.37f, 0.38f, 1}},
                          {{0.50f, 0.28f, 0.21f, 1}}});
    builder.solid("hills", hills(), grass);
    builder.solid("plain", ground(plain_half, plain_half, 1, 1), earth);

    const int pylon_mesh = builder.mesh(pylon(), steel);
    std::vector<glm::dvec3> feet;
    for (int i = 0; i < 5; ++i) {
        const double x = -220 + 110 * i, z = -0.12 * x;
        feet.emplace_back(x, height(x, z), z);
        builder.node("pylon_" + std::to_string(i), pylon_mesh, feet.back());
    }
    Shape wires;
    for (size_t i = 1; i < feet.size(); ++i)
        for (const double y : arms)
            for (const double side : {-arm_half, arm_half})
                wires.append(
                    wire(feet[i - 1] + glm::dvec3(0, y, side), feet[i] + glm::dvec3(0, y, side), 3.5));
    builder.solid("wires", std::move(wires), steel);
    builder.node("barn", builder.mesh(barn(), brick), {-35, height(-35, 30), 30});
    return builder.take();
}

}  // namespace penumbra
