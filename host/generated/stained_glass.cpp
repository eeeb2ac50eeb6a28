// SPDX-License-Identifier: MIT
#include "host/generated/stained_glass.h"

#include <array>
#include <cmath>
#include <numbers>

#include "host/generated/noise.h"
#include "host/models/model_builder.h"

namespace penumbra {
namespace {

enum : int { plaster, stone, iron, red_glass, blue_glass, green_film, yellow_film, painted_glass, lace };

constexpr double wall_x = 3, sill = 0.9, lintel = 2.9, window_z = 1.5;  // the window is 3 m wide
constexpr int columns = 6, rows = 4;

// Facing along x.
Shape pane(double x, double y0, double y1, double z0, double z1) {
    Shape shape;
    const std::array<glm::vec2, 4> uv{glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0), glm::vec2(0, 0)};
    for (const glm::vec2& at : uv) {
        shape.positions.emplace_back(x, y1 + (y0 - y1) * double(at.y), z0 + (z1 - z0) * double(at.x));
        shape.uv.push_back(at);
    }
    shape.indices = {0, 1, 2, 0, 2, 3};
    return shape;
}

Shape leads() {
    Shape shape;
    for (int i = 0; i <= columns; ++i) {
        const double z = -window_z + 2 * window_z * i / columns;
        shape.append(box({wall_x - 0.01, sill, z - 0.012}, {wall_x + 0.01, lintel, z + 0.012}));
    }
    for (int i = 0; i <= rows; ++i) {
        const double y = sill + (lintel - sill) * i / rows;
        shape.append(box({wall_x - 0.01, y - 0.012, -window_z}, {wall_x + 0.01, y + 0.012, window_z}));
    }
    return shape;
}

// A rose of petals in three colours, transparent between them.
Texture rose() {
    constexpr uint32_t size = 128;
    Texture texture{size, size, {}};
    for (uint32_t row = 0; row < size; ++row)
        for (uint32_t column = 0; column < size; ++column) {
            const double x = (column + 0.5) / size * 2 - 1, y = (row + 0.5) / size * 2 - 1;
            const double r = std::hypot(x, y), angle = std::atan2(y, x);
            const double petal = 0.62 + 0.3 * std::cos(6 * angle);
            const bool heart = r < 0.22;
            const std::array<uint8_t, 3> color = heart       ? std::array<uint8_t, 3>{250, 210, 60}
                                                 : r < petal ? std::array<uint8_t, 3>{210, 40, 70}
                                                             : std::array<uint8_t, 3>{70, 130, 220};
            const uint8_t alpha = heart ? 200 : r < petal ? 255 : 120;
            texture.rgba.insert(texture.rgba.end(), {color[0], color[1], color[2], alpha});
        }
    return texture;
}

// Threads that cross, with knots: white, its alpha how closely they lie.
Texture lace_texture() {
    constexpr uint32_t size = 256;
    Texture texture{size, size, {}};
    for (uint32_t row = 0; row < size; ++row)
        for (uint32_t column = 0; column < size; ++column) {
            const double u = (column + 0.5) / size * 2 * std::numbers::pi,
                         v = (row + 0.5) / size * 2 * std::numbers::pi;
            const double threads = 0.5 + 0.25 * (std::cos(8 * u + 8 * v) + std::cos(8 * u - 8 * v));
            const double flowers = std::max(0.0, std::sin(2 * u) * std::sin(2 * v));
            const double alpha = std::min(0.15 + 0.55 * threads * threads + 0.8 * flowers * flowers, 1.0);
            texture.rgba.insert(texture.rgba.end(),
                                {245, 240, 230, static_cast<uint8_t>(std::lround(255 * alpha))});
        }
    return texture;
}

// Hangs in folds beside the window, inside the room.
Shape curtain() {
    constexpr int folds = 48;
    Shape shape;
    for (int i = 0; i <= folds; ++i) {
        const double t = double(i) / folds, z = 0.5 + 0.95 * t, x = wall_x - 0.25 + 0.06 * std::sin(22 * t);
        for (const double y : {0.15, 3.0}) {
            shape.positions.emplace_back(x, y, z);
            shape.uv.emplace_back(2 * t, (3.0 - y) / 1.4);
        }
        if (i == 0) continue;
        const auto at = static_cast<uint32_t>(2 * i);
        shape.indices.insert(shape.indices.end(), {at - 2, at - 1, at + 1, at - 2, at + 1, at});
    }
    return shape;
}

Shape lattice() {
    Shape shape;
    for (int i = 0; i < 5; ++i)
        shape.append(rod({wall_x + 0.6, sill - 0.3, -1.4 + 0.35 * i},
                         {wall_x + 0.6, lintel + 0.4, -1.4 + 0.35 * i}, 0.015, 12));
    return shape;
}

Material dull(float r, float g, float b) {
    Material material;
    material.base_color = {r, g, b, 1};
    return material;
}

Material glass(float r, float g, float b) {
    Material material = dull(r, g, b);
    material.transmission = 1;
    material.roughness = 0;
    return material;
}

Material film(float r, float g, float b, float alpha) {
    Material material = dull(r, g, b);
    material.base_color[3] = alpha;
    material.alpha_blend = true;
    return material;
}

}  // namespace

Model make_stained_glass() {
    Material painted = film(1, 1, 1, 1), threads = film(1, 1, 1, 1);
    painted.texture = 0;
    painted.transmission = 0.9f;
    threads.texture = 1;
    // A film's own colour does not tint what goes through it; that of glass does.
    ModelBuilder builder({dull(0.75f, 0.73f, 0.7f), dull(0.5f, 0.48f, 0.45f), dull(0.12f, 0.12f, 0.13f),
                          glass(0.85f, 0.08f, 0.1f), glass(0.1f, 0.25f, 0.9f), film(0.2f, 0.5f, 0.2f, 0.6f),
                          glass(0.95f, 0.8f, 0.15f), painted, threads},
                         {rose(), lace_texture()});
    builder.solid("floor", ground(8, 8, 16, 16), stone);
    builder.solid("far", box({-3, 0, -2.6}, {wall_x, 3.2, -2.5}), plaster);
    builder.solid("left", box({-3.1, 0, -2.6}, {-3, 3.2, 2.5}), plaster);
    builder.solid("roof", box({-3.1, 3.2, -2.6}, {wall_x + 0.1, 3.3, 2.5}), plaster);
    const double outer = wall_x + 0.1;
    builder.solid("parapet", box({wall_x, 0, -2.6}, {outer, sill, 2.5}), plaster);
    builder.solid("beam", box({wall_x, lintel, -2.6}, {outer, 3.2, 2.5}), plaster);
    builder.solid("pier", box({wall_x, sill, -2.6}, {outer, lintel, -window_z}), plaster);
    builder.solid("pier", box({wall_x, sill, window_z}, {outer, lintel, 2.5}), plaster);
    builder.solid("leads", leads(), iron);
    builder.solid("lattice", lattice(), iron);
    std::array<Shape, 5> panes;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const double z = -window_z + 2 * window_z * column / columns,
                         y = sill + (lintel - sill) * row / rows;
            const uint32_t kind = pcg(static_cast<uint32_t>(row * columns + column)) % 5;
            panes[kind].append(pane(wall_x, y, y + (lintel - sill) / rows, z, z + 2 * window_z / columns));
        }
    for (size_t kind = 0; kind < panes.size(); ++kind)
        if (!panes[kind].indices.empty())
            builder.solid("panes", std::move(panes[kind]), red_glass + static_cast<int>(kind));
    builder.solid("curtain", curtain(), lace);
    // Two sheets that overlap, the one behind the other.
    builder.solid("stand", box({0.7, 0, -1.3}, {1.5, 0.5, -0.5}), stone);
    builder.solid("sheet_fixed", pane(1.35, 0.5, 1.3, -1.2, -0.7), blue_glass);
    builder.node("sheet", builder.mesh(pane(0, 0, 0.8, -0.25, 0.25), yellow_film), {1.15, 0.5, -0.75});
    builder.solid("post", rod({-1.2, 0, 0.4}, {-1.2, 1.4, 0.4}, 0.05, 24), iron);
    return builder.take();
}

}  // namespace penumbra
