// SPDX-License-Identifier: MIT
#include "host/generated/street.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/generated/noise.h"
#include "host/models/model_builder.h"

namespace penumbra {
namespace {

// Green is roughness: puddles of .04 between asphalt of up to .6, borders about half a metre wide.
Texture wetness() {
    constexpr uint32_t size = 256;
    Texture texture{size, size, {}};
    for (uint32_t y = 0; y < size; ++y)
        for (uint32_t x = 0; x < size; ++x) {
            const double height = fractal_noise(x / 32.0, y / 32.0, 3, 0.5, 7);
            const double rough = std::clamp(0.3 + 0.6 * height, 0.04, 0.6);
            texture.rgba.insert(texture.rgba.end(),
                                {0, static_cast<uint8_t>(std::lround(255 * rough)), 0, 255});
        }
    return texture;
}

// Brick with windows, of which a third is lit; two textures of one layout.
Texture facade(bool lit) {
    constexpr uint32_t size = 64;
    Texture texture{size, size, {}};
    for (uint32_t y = 0; y < size; ++y)
        for (uint32_t x = 0; x < size; ++x) {
            const bool window = x % 8 >= 2 && x % 8 < 6 && y % 16 >= 5 && y % 16 < 12;
            const bool on = window && pcg(x / 8 + 977 * (y / 16)) % 3 == 0;
            const uint8_t brick = y % 2 ? 90 : 110;
            const std::array<uint8_t, 3> color =
                lit      ? (on ? std::array<uint8_t, 3>{255, 225, 170} : std::array<uint8_t, 3>{0, 0, 0})
                : window ? std::array<uint8_t, 3>{20, 22, 28}
                         : std::array<uint8_t, 3>{brick, 60, 50};
            texture.rgba.insert(texture.rgba.end(), {color[0], color[1], color[2], 255});
        }
    return texture;
}

// From `corner` along u and v; texture coordinates repeat `u_times`, `v_times`.
Shape wall(const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v, int cells, double u_times,
           double v_times) {
    Shape shape;
    for (int j = 0; j <= cells; ++j)
        for (int i = 0; i <= cells; ++i) {
            const double s = double(i) / cells, t = double(j) / cells;
            shape.positions.emplace_back(corner + s * u + t * v);
            shape.uv.emplace_back(u_times * s, v_times * t);
        }
    for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
            const auto a = static_cast<uint32_t>(j * (cells + 1) + i),
                       b = a + static_cast<uint32_t>(cells + 1);
            shape.indices.insert(shape.indices.end(), {a, a + 1, b + 1, a, b + 1, b});
        }
    return shape;
}

Shape bulb(const glm::dvec3& place, double radius) {
    std::vector<ProfilePoint> profile;
    constexpr int rings = 12;
    for (int i = 0; i <= rings; ++i) {
        const double angle = std::numbers::pi * (i + 0.25) / (rings + 0.5);
        profile.push_back({-radius * std::cos(angle), radius * std::sin(angle)});
    }
    Shape shape = lathe(profile, 16);
    glm::dmat4 matrix(1);
    matrix[3] = glm::dvec4(place, 1);
    shape.transform(matrix);
    return shape;
}

Material surface(std::array<float, 4> color, float roughness, float metallic = 0) {
    Material material;
    material.base_color = color;
    material.roughness = roughness;
    material.metallic = metallic;
    return material;
}

}  // namespace

Model make_street() {
    enum : int { asphalt, brick, post, paint, tail_light, bulbs };
    Material wet = surface({0.08f, 0.08f, 0.09f, 1}, 1);
    wet.metallic_roughness_texture = 0;
    Material front = surface({1, 1, 1, 1}, 0.75f);
    front.texture = 1;
    front.emissive = {2.2f, 2.0f, 1.6f};
    front.emissive_texture = 2;
    Material red = surface({0.3f, 0.02f, 0.02f, 1}, 0.3f), warm = surface({0.8f, 0.8f, 0.8f, 1}, 0.6f);
    red.emissive = {40, 2, 1};
    warm.emissive = {260, 190, 110};
    ModelBuilder builder({wet, front, surface({0.5f, 0.5f, 0.52f, 1}, 0.35f, 1),
                          surface({0.1f, 0.25f, 0.5f, 1}, 0.12f, 1), red, warm},
                         {wetness(), facade(false), facade(true)});
    builder.solid("street", wall({-6, 0, 6}, {12, 0, 0}, {0, 0, -36}, 24, 2, 6), asphalt);
    builder.solid("left", wall({-6, 0, 6}, {0, 0, -36}, {0, 9, 0}, 12, 6, 1.5), brick);
    builder.solid("right", wall({6, 0, -30}, {0, 0, 36}, {0, 9, 0}, 12, 6, 1.5), brick);
    builder.solid("end", wall({-6, 0, -30}, {12, 0, 0}, {0, 9, 0}, 8, 2, 1.5), brick);
    for (int i = 0; i < 10; ++i) {
        const double x = i % 2 ? 4.2 : -4.2, z = 2 - 3.2 * i;
        builder.solid("post", rod({x, 0, z}, {x, 3.4, z}, 0.05, 12), post);
        builder.solid("bulb", bulb({x, 3.5, z}, 0.07), bulbs);
    }
    Shape body = box({-0.85, 0.25, -2}, {0.85, 0.85, 2});
    body.append(box({-0.7, 0.85, -1.1}, {0.7, 1.4, 1.2}));
    Shape lights = box({-0.75, 0.6, 2}, {-0.5, 0.7, 2.02});
    lights.append(box({0.5, 0.6, 2}, {0.75, 0.7, 2.02}));
    const int car = builder.mesh(body, paint), rear = builder.mesh(lights, tail_light);
    builder.node("car", car, {1.6, 0, -4});
    builder.node("rear", rear, {1.6, 0, -4});
    return builder.take();
}

}  // namespace penumbra
