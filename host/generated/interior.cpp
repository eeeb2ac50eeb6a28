// SPDX-License-Identifier: MIT
#include "host/generated/interior.h"

#include <array>

#include "host/models/model_builder.h"

namespace penumbra {
namespace {

enum : int { plaster, planks, wood, metal, paint };

Shape table() {
    Shape shape = box({-0.7, 0.72, -0.4}, {0.7, 0.76, 0.4});
    for (const double x : {-0.64, 0.64})
        for (const double z : {-0.34, 0.34}) shape.append(rod({x, 0, z}, {x, 0.72, z}, 0.03, 16));
    return shape;
}

Shape chair() {
    Shape shape = box({-0.2, 0.42, -0.2}, {0.2, 0.45, 0.2});
    for (const double x : {-0.18, 0.18})
        for (const double z : {-0.18, 0.18})
            shape.append(rod({x, 0, z}, {x, z < 0 ? 0.95 : 0.42, z}, 0.018, 12));
    for (const double y : {0.6, 0.75, 0.9}) shape.append(rod({-0.18, y, -0.18}, {0.18, y, -0.18}, 0.012, 10));
    return shape;
}

// Books of many widths and heights on three boards.
Shape shelf() {
    Shape shape;
    for (int board = 0; board < 4; ++board)
        shape.append(box({-0.6, 0.45 * board, 0}, {0.6, 0.45 * board + 0.025, 0.26}));
    for (const double x : {-0.625, 0.6}) shape.append(box({x, 0, 0}, {x + 0.025, 1.4, 0.26}));
    for (int board = 0; board < 3; ++board) {
        double x = -0.58;
        for (int i = 0; x < 0.5; ++i) {
            const double width = 0.02 + 0.005 * (i * 7 % 5), height = 0.2 + 0.02 * ((i * 5 + board) % 8);
            const double low = 0.45 * board + 0.026;
            shape.append(box({x, low, 0.02}, {x + width, low + height, 0.02 + 0.15 + 0.01 * (i % 4)}));
            x += width + (i % 9 == 8 ? 0.09 : 0.003);
        }
    }
    return shape;
}

Shape vase() {
    const std::array<ProfilePoint, 6> profile{
        {{0, 0.05}, {0.04, 0.08}, {0.12, 0.09}, {0.2, 0.04}, {0.25, 0.035}, {0.28, 0.055}}};
    return lathe(profile, 48);
}

// Upright and lying bars of 16 mm.
Shape grating() {
    Shape shape;
    for (int i = 0; i < 9; ++i)
        shape.append(rod({0, 0, -0.48 + 0.12 * i}, {0, 1.2, -0.48 + 0.12 * i}, 0.008, 12));
    for (int i = 0; i < 5; ++i)
        shape.append(rod({0.02, 0.12 + 0.24 * i, -0.5}, {0.02, 0.12 + 0.24 * i, 0.5}, 0.008, 12));
    return shape;
}

Shape mobile() {
    Shape shape = rod({0, 0, 0}, {0, -0.5, 0}, 0.004, 8);
    shape.append(rod({-0.35, -0.5, 0}, {0.35, -0.5, 0}, 0.006, 8));
    for (const double x : {-0.35, -0.12, 0.12, 0.35}) {
        shape.append(rod({x, -0.5, 0}, {x, -0.6, 0}, 0.003, 8));
        shape.append(box({x - 0.05, -0.72, -0.01}, {x + 0.05, -0.6, 0.01}));
    }
    return shape;
}

}  // namespace

Model make_interior() {
    const auto dull = [](float r, float g, float b) {
        Material material;
        material.base_color = {r, g, b, 1};
        return material;
    };
    ModelBuilder builder({dull(0.8f, 0.78f, 0.72f), dull(0.45f, 0.3f, 0.2f), dull(0.5f, 0.36f, 0.22f),
                          dull(0.3f, 0.3f, 0.32f), dull(0.25f, 0.4f, 0.55f)});
    builder.solid("ground", box({-3, -0.1, -2}, {3, 0, 2}), planks);
    builder.solid("ceiling", box({-3, 2.8, -2}, {3, 2.9, 2}), plaster);
    builder.solid("far", box({-3, 0, -2.1}, {3, 2.8, -2}), plaster);
    builder.solid("wall", box({3, 0, -2}, {3.1, 2.8, 2}), plaster);
    // The left wall around its opening, 1 m wide and 1.2 m high.
    builder.solid("sill", box({-3.1, 0, -2}, {-3, 0.9, 2}), plaster);
    builder.solid("lintel", box({-3.1, 2.1, -2}, {-3, 2.8, 2}), plaster);
    builder.solid("pier", box({-3.1, 0.9, -2}, {-3, 2.1, -0.5}), plaster);
    builder.solid("pier", box({-3.1, 0.9, 0.5}, {-3, 2.1, 2}), plaster);
    builder.node("grating", builder.mesh(grating(), metal), {-3.05, 0.9, 0});
    builder.node("table", builder.mesh(table(), wood), {0.4, 0, -0.2});
    const int one_chair = builder.mesh(chair(), wood);
    builder.node("chair", one_chair, {0.1, 0, -0.75});
    builder.node("chair", one_chair, {1.5, 0, 0.3});
    builder.node("shelf", builder.mesh(shelf(), wood), {-1.4, 0, -2});
    builder.node("vase", builder.mesh(vase(), paint), {0.65, 0.76, -0.3});
    builder.node("mobile", builder.mesh(mobile(), metal), {-0.9, 2.8, 0.2});
    return builder.take();
}

}  // namespace penumbra
