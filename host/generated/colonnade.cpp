// SPDX-License-Identifier: MIT
// Dimensions in metres. The nave is 5.2 m wide and runs along z; the sun of the colonnade's shot comes from
// +x.
#include "host/generated/colonnade.h"

#include <array>
#include <cmath>
#include <string>

#include "host/models/model_builder.h"

namespace penumbra {

namespace {

constexpr double row_x = 2.6;       // the columns' axes
constexpr double spacing_z = 3.2;   // between columns
constexpr int columns_per_row = 6;  // at z = -8 .. 8
constexpr double shaft_height = 4.6;
constexpr double beam_bottom = 5.1;

double column_z(int i) {
    return (i - 0.5 * (columns_per_row - 1)) * spacing_z;
}

enum MaterialIndex { floor_stone, marble, bronze, iron, wood };

std::vector<Material> materials() {
    return {{{0.42f, 0.40f, 0.37f, 1}},
            {{0.72f, 0.69f, 0.62f, 1}},
            {{0.45f, 0.29f, 0.13f, 1}},
            {{0.16f, 0.17f, 0.19f, 1}},
            {{0.38f, 0.24f, 0.14f, 1}}};
}

// Attic base, fluted shaft that tapers with entasis, capital and abacus.
Shape column() {
    Shape shape = box({-0.52, 0, -0.52}, {0.52, 0.12, 0.52});
    constexpr std::array<ProfilePoint, 9> base{{{0.12, 0.48},
                                                {0.17, 0.505},
                                                {0.23, 0.48},
                                                {0.26, 0.43},
                                                {0.31, 0.42},
                                                {0.35, 0.45},
                                                {0.39, 0.46},
                                                {0.43, 0.44},
                                                {0.45, 0.40}}};
    shape.append(lathe(base, 64));
    std::vector<ProfilePoint> shaft;
    constexpr int rings = 12;
    for (int i = 0; i <= rings; ++i) {
        const double t = double(i) / rings;
        shaft.push_back({0.45 + t * (shaft_height - 0.45), 0.37 - 0.06 * t * t});
    }
    // 20 flutes of 7 segments each: arcs that dip by 6 % between sharp arrises.
    shape.append(lathe(shaft, 140, [](double angle) { return 1 - 0.06 * std::abs(std::sin(10 * angle)); }));
    constexpr std::array<ProfilePoint, 6> capital{{{shaft_height, 0.32},
                                                   {shaft_height + 0.06, 0.36},
                                                   {shaft_height + 0.10, 0.34},
                                                   {shaft_height + 0.16, 0.36},
                                                   {shaft_height + 0.27, 0.47},
                                                   {shaft_height + 0.32, 0.49}}};
    shape.append(lathe(capital, 64));
    shape.append(box({-0.54, shaft_height + 0.32, -0.54}, {0.54, beam_bottom, 0.54}));
    return shape;
}

// The beam over a row, with dentils under its cornice.
Shape beam() {
    const double half_z = column_z(columns_per_row - 1) + 0.7;
    Shape shape = box({-0.42, beam_bottom, -half_z}, {0.42, beam_bottom + 0.5, half_z});
    shape.append(box({-0.62, beam_bottom + 0.62, -half_z - 0.2}, {0.62, beam_bottom + 0.78, half_z + 0.2}));
    for (double z = -half_z + 0.06; z < half_z - 0.1; z += 0.24) {
        shape.append(box({-0.54, beam_bottom + 0.5, z}, {0.54, beam_bottom + 0.62, z + 0.12}));
    }
    return shape;
}

// Round bars along z every `pitch` metres over [x0, x1], on flat bearers.
Shape grating(double x0, double x1, double z0, double z1, double y, double pitch, double bar_radius) {
    Shape shape;
    const int bars = static_cast<int>((x1 - x0) / pitch);
    for (int i = 0; i <= bars; ++i) {
        const double x = x0 + i * (x1 - x0) / bars;
        shape.append(rod({x, y, z0}, {x, y, z1}, bar_radius, 10));
    }
    for (int i = 0; i <= 4; ++i) {
        const double z = z0 + i * (z1 - z0) / 4;
        shape.append(box({x0 - 0.02, y - 0.05, z - 0.012}, {x1 + 0.02, y - 0.01, z + 0.012}));
    }
    return shape;
}

// Turned balusters under a rail, along z.
Shape railing(double z0, double z1) {
    constexpr std::array<ProfilePoint, 9> baluster{{{0.06, 0.045},
                                                    {0.12, 0.05},
                                                    {0.16, 0.022},
                                                    {0.30, 0.05},
                                                    {0.42, 0.042},
                                                    {0.62, 0.018},
                                                    {0.72, 0.024},
                                                    {0.78, 0.045},
                                                    {0.86, 0.045}}};
    Shape shape = box({-0.07, 0, z0}, {0.07, 0.06, z1});
    shape.append(box({-0.08, 0.86, z0}, {0.08, 0.94, z1}));
    const Shape one = lathe(baluster, 16);
    const int count = static_cast<int>((z1 - z0) / 0.19);
    for (int i = 0; i < count; ++i) {
        Shape placed = one;
        for (glm::vec3& p : placed.positions) p.z += static_cast<float>(z0 + (i + 0.5) * (z1 - z0) / count);
        shape.append(placed);
    }
    return shape;
}

// A grid of square bars that fills an opening between two columns, in the plane x = 0.
Shape gate() {
    Shape shape;
    const double half = 0.5 * spacing_z - 0.55;
    for (int i = 0; i <= 12; ++i) {
        const double z = -half + i * 2 * half / 12;
        shape.append(box({-0.014, 0.05, z - 0.014}, {0.014, 2.6, z + 0.014}));
        shape.append(lathe(std::array<ProfilePoint, 2>{{{2.6, 0.026}, {2.78, 0.001}}}, 12));
        for (size_t k = shape.positions.size() - 26; k < shape.positions.size(); ++k) {
            shape.positions[k].z += static_cast<float>(z);
        }
    }
    for (const double y : {0.25, 1.05, 1.85, 2.45}) {
        shape.append(box({-0.02, y, -half - 0.03}, {0.02, y + 0.045, half + 0.03}));
    }
    return shape;
}

Shape steps() {
    Shape shape;
    for (int i = 0; i < 6; ++i) {
        shape.append(box({-2.0, 0.16 * i, -11.6}, {2.0, 0.16 * (i + 1), -8.8 - 0.34 * i}));
    }
    return shape;
}

}  // namespace

Model make_colonnade() {
    ModelBuilder builder(materials());
    builder.solid("floor", ground(24, 24, 48, 48), floor_stone);

    const int column_mesh = builder.mesh(column(), marble);
    const int beam_mesh = builder.mesh(beam(), marble);
    for (const double x : {-row_x, row_x}) {
        const std::string row = x < 0 ? "left" : "right";
        for (int i = 0; i < columns_per_row; ++i) {
            builder.node("column_" + row + "_" + std::to_string(i), column_mesh, {x, 0, column_z(i)});
        }
        builder.node("beam_" + row, beam_mesh, {x, 0, 0});
    }

    // Railings between columns 3-4 and 4-5 of the right row, in the sun's way; one on the left for its own
    // shade.
    const double bay = 0.5 * spacing_z - 0.55;
    const int railing_mesh = builder.mesh(railing(-bay, bay), marble);
    for (int i = 3; i < 5; ++i) {
        builder.node("railing_right_" + std::to_string(i), railing_mesh,
                     {row_x, 0, column_z(i) + 0.5 * spacing_z});
    }
    builder.node("railing_left", railing_mesh, {-row_x, 0, column_z(1) + 0.5 * spacing_z});

    // Gratings: a low pergola beside the nave, and one on the beams, whose bars' shadows have run together on
    // the floor.
    builder.solid("grating_low", grating(3.4, 5.4, -1.4, 3.4, 2.3, 0.16, 0.018), wood);
    builder.solid("grating_high", grating(-2.2, 2.2, -7.6, -1.8, beam_bottom + 0.3, 0.22, 0.03), wood);
    Shape posts;
    for (const double x : {3.4, 5.4})
        for (const double z : {-1.4, 3.4})
            posts.append(box({x - 0.06, 0, z - 0.06}, {x + 0.06, 2.25, z + 0.06}));
    builder.solid("grating_posts", std::move(posts), wood);

    // Chains from column to column on the right, low ones across bollards at the front.
    for (int i = 2; i < 5; ++i) {
        builder.solid("chain_high_" + std::to_string(i),
                      chain({row_x - 0.4, 3.4, column_z(i)}, {row_x - 0.4, 3.4, column_z(i + 1)}, 0.9, 0.016),
                      iron);
    }
    constexpr std::array<ProfilePoint, 6> bollard{
        {{0, 0.13}, {0.06, 0.13}, {0.10, 0.085}, {0.72, 0.07}, {0.78, 0.10}, {0.86, 0.05}}};
    const int bollard_mesh = builder.mesh(lathe(bollard, 32), bronze);
    const std::array<glm::dvec3, 4> bollards{{{-1.7, 0, 3.1}, {-0.3, 0, 3.6}, {1.1, 0, 3.1}, {2.0, 0, 1.7}}};
    for (size_t i = 0; i < bollards.size(); ++i) {
        builder.node("bollard_" + std::to_string(i), bollard_mesh, bollards[i]);
        if (i == 0) continue;
        const glm::dvec3 top(0, 0.75, 0);
        builder.solid("chain_low_" + std::to_string(i - 1),
                      chain(bollards[i - 1] + top, bollards[i] + top, 0.3, 0.012), iron);
    }

    builder.node("gate", builder.mesh(gate(), iron), {row_x, 0, column_z(2) + 0.5 * spacing_z});
    builder.solid("steps", steps(), marble);
    return builder.take();
}

}  // namespace penumbra
