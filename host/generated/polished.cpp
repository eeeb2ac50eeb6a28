// SPDX-License-Identifier: MIT
#include "host/generated/polished.h"

#include <cmath>
#include <numbers>

#include "host/models/model_builder.h"

namespace penumbra {
namespace {

// Perceptual roughness from 0 at u = 0 to this at u = 1.
constexpr double roughest = 0.8;

Texture pattern(uint32_t width, uint32_t height,
                const std::function<std::array<uint8_t, 3>(uint32_t, uint32_t)>& color) {
    Texture texture{width, height, {}};
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const auto [r, g, b] = color(x, y);
            texture.rgba.insert(texture.rgba.end(), {r, g, b, 255});
        }
    return texture;
}

Texture roughness_ramp() {
    return pattern(256, 1, [](uint32_t x, uint32_t) {
        return std::array<uint8_t, 3>{0, static_cast<uint8_t>(std::lround(roughest * x)), 0};
    });
}

Texture checkers() {
    return pattern(64, 64, [](uint32_t x, uint32_t y) {
        const bool dark = ((x / 8) ^ (y / 8)) & 1;
        return dark ? std::array<uint8_t, 3>{70, 40, 30} : std::array<uint8_t, 3>{225, 215, 190};
    });
}

Texture stripes() {
    return pattern(64, 1, [](uint32_t x, uint32_t) {
        return x / 4 % 2 ? std::array<uint8_t, 3>{35, 60, 120} : std::array<uint8_t, 3>{230, 230, 225};
    });
}

// A rectangle from `corner` along `u` and `v`, in cells; texture coordinates 0..1 over all of it. Seen from u
// x v.
Shape panel(const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v, int cells_u, int cells_v) {
    Shape shape;
    for (int j = 0; j <= cells_v; ++j)
        for (int i = 0; i <= cells_u; ++i) {
            const double s = double(i) / cells_u, t = double(j) / cells_v;
            shape.positions.emplace_back(corner + s * u + t * v);
            shape.uv.emplace_back(s, t);
        }
    for (int j = 0; j < cells_v; ++j)
        for (int i = 0; i < cells_u; ++i) {
            const auto a = static_cast<uint32_t>(j * (cells_u + 1) + i),
                       b = a + static_cast<uint32_t>(cells_u + 1);
            shape.indices.insert(shape.indices.end(), {a, a + 1, b + 1, a, b + 1, b});
        }
    return shape;
}

Shape sphere(double radius) {
    std::vector<ProfilePoint> profile;
    constexpr int rings = 48;
    for (int i = 0; i <= rings; ++i) {
        const double angle = std::numbers::pi * (i + 0.25) / (rings + 0.5);
        profile.push_back({-radius * std::cos(angle), radius * std::sin(angle)});
    }
    return lathe(profile, 96);
}

Shape at(Shape shape, const glm::dvec3& place) {
    glm::dmat4 matrix(1);
    matrix[3] = glm::dvec4(place, 1);
    shape.transform(matrix);
    return shape;
}

Material painted(std::array<float, 4> color, float roughness, float metallic = 0, int texture = -1) {
    Material material;
    material.base_color = color;
    material.roughness = roughness;
    material.metallic = metallic;
    material.texture = texture;
    return material;
}

Material shining(std::array<float, 3> emissive) {
    Material material = painted({0.8f, 0.8f, 0.8f, 1}, 0.6f);
    material.emissive = emissive;
    return material;
}

}  // namespace

Model make_polished() {
    enum : int { floor, checkered, striped, red, lamp, glow };
    Material polished = painted({0.5f, 0.5f, 0.52f, 1}, 1, 1);
    polished.metallic_roughness_texture = 2;
    polished.metallic = 0;  // the texture's blue is 0 as well
    ModelBuilder builder(
        {polished, painted({1, 1, 1, 1}, 0.7f, 0, 0), painted({1, 1, 1, 1}, 0.4f, 0, 1),
         painted({0.7f, 0.12f, 0.08f, 1}, 0.25f), shining({60, 52, 40}), shining({3, 2.4f, 1.6f})},
        {checkers(), stripes(), roughness_ramp()});
    builder.solid("floor", panel({-6, 0, 4}, {12, 0, 0}, {0, 0, -10}, 24, 20), floor);
    builder.solid("back", panel({-6, 0, -6}, {12, 0, 0}, {0, 3.5, 0}, 24, 7), checkered);
    builder.solid("left", panel({-6, 0, 4}, {0, 0, -10}, {0, 3.5, 0}, 20, 7), striped);
    builder.solid("right", panel({6, 0, -6}, {0, 0, 10}, {0, 3.5, 0}, 20, 7), checkered);
    for (int i = 0; i < 7; ++i) {
        const double x = -4.8 + 1.6 * i;
        builder.solid("pole", rod({x, 0, -2.5 - 0.7 * (i % 3)}, {x, 2.2, -2.5 - 0.7 * (i % 3)}, 0.07, 24),
                      red);
    }
    builder.solid("bar", box({-5.5, 2.3, -5.2}, {5.5, 2.45, -5.05}), glow);
    builder.solid("lamp", at(sphere(0.09), {1.2, 1.3, -1.6}), lamp);
    const int carriage = builder.mesh(box({-0.35, 0, -0.35}, {0.35, 0.9, 0.35}), striped);
    builder.node("carriage", carriage, {-2.6, 0.02, -0.8});
    return builder.take();
}

Model make_chrome() {
    enum : int { floor, wall, panel_light, first };
    std::vector<Material> materials{painted({1, 1, 1, 1}, 0.35f, 0, 0), painted({1, 1, 1, 1}, 0.8f, 0, 1),
                                    shining({9, 8.5f, 8})};
    const float roughness[] = {0, 0.1f, 0.2f, 0.4f, 0.7f};
    for (const float r : roughness) materials.push_back(painted({0.95f, 0.93f, 0.9f, 1}, r, 1));
    for (const float r : roughness) materials.push_back(painted({0.9f, 0.55f, 0.3f, 1}, r, 1));
    ModelBuilder builder(materials, {checkers(), stripes()});
    builder.solid("floor", panel({-7, 0, 5}, {14, 0, 0}, {0, 0, -12}, 28, 24), floor);
    builder.solid("back", panel({-7, 0, -7}, {14, 0, 0}, {0, 4, 0}, 28, 8), wall);
    builder.solid("light", panel({-2, 3.4, -6.9}, {4, 0, 0}, {0, 0.5, 0}, 4, 1), panel_light);
    for (int i = 0; i < 5; ++i) {
        builder.solid("chrome", at(sphere(0.55), {-3 + 1.5 * i, 0.56, -0.6}), first + i);
        builder.solid("copper", at(sphere(0.45), {-2.4 + 1.2 * i, 0.46, 1.1}), first + 5 + i);
    }
    return builder.take();
}

}  // namespace penumbra
