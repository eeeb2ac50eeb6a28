// SPDX-License-Identifier: MIT
// Leaves are ovals pointed at both ends, of which a texel knows roughly how far inside it lies.
#include "host/generated/leaf_card.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace penumbra {

namespace {

constexpr uint32_t size = 128;

// In texels from the lower border's middle, y upwards.
struct Leaf {
    glm::dvec2 foot, along;  // along: from the foot to the tip
    double half_width;
};

constexpr std::array<Leaf, 7> leaves{{{{0, 84}, {0, 42}, 10},
                                      {{0, 62}, {38, 30}, 10},
                                      {{0, 56}, {-40, 28}, 10},
                                      {{0, 38}, {46, 18}, 11},
                                      {{0, 33}, {-47, 16}, 11},
                                      {{0, 14}, {40, 6}, 9},
                                      {{0, 11}, {-42, 3}, 9}}};
constexpr double stalk_top = 88, stalk_half_width = 1.6;

// Texels to the outline, positive inside; right in sign, and near the outline roughly in size.
double depth_inside(const glm::dvec2& p) {
    double inside = std::min(stalk_half_width - std::abs(p.x), stalk_top - p.y);
    for (const Leaf& leaf : leaves) {
        const double length = glm::length(leaf.along);
        const glm::dvec2 axis = leaf.along / length, q = p - leaf.foot;
        const double t = glm::dot(q, axis) / length, across = std::abs(q.x * axis.y - q.y * axis.x);
        const double outline =
            t <= 0 || t >= 1 ? -length * std::max(-t, t - 1) : leaf.half_width * 4 * t * (1 - t);
        inside = std::max(inside, outline - across);
    }
    return inside;
}

}  // namespace

Texture leaf_card_texture() {
    Texture texture{size, size, {}};
    for (uint32_t row = 0; row < size; ++row)
        for (uint32_t column = 0; column < size; ++column) {
            const double inside = depth_inside({column + 0.5 - size / 2.0, size - 0.5 - row});
            const double alpha = std::clamp(0.5 + 0.5 * inside, 0.0, 1.0);
            texture.rgba.insert(texture.rgba.end(),
                                {96, 138, 60, static_cast<uint8_t>(std::lround(255 * alpha))});
        }
    return texture;
}

void add_leaf_card(Shape& leaves_shape, const glm::dvec3& foot, const glm::dvec3& along,
                   const glm::dvec3& side, double length) {
    const auto first = static_cast<uint32_t>(leaves_shape.positions.size());
    for (const glm::vec2 uv : {glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0), glm::vec2(0, 0)}) {
        leaves_shape.positions.emplace_back(foot + length * ((uv.x - 0.5) * side + (1.0 - uv.y) * along));
        leaves_shape.uv.push_back(uv);
    }
    leaves_shape.indices.insert(leaves_shape.indices.end(),
                                {first, first + 1, first + 2, first, first + 2, first + 3});
}

}  // namespace penumbra
