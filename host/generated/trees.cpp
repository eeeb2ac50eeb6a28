// SPDX-License-Identifier: MIT
// A tree is a tube that forks: each branch carries shorter ones, the thinnest carry leaves. Dimensions in
// metres.
#include "host/generated/trees.h"

#include <array>
#include <glm/gtc/constants.hpp>

#include "host/generated/leaf_card.h"
#include "host/generated/noise.h"
#include "host/models/model_builder.h"

namespace penumbra {

namespace {

constexpr double half_size = 20;

enum MaterialIndex { soil, bark, foliage };

double terrain_height(double x, double z) {
    // Flattened towards the middle, where the camera stands.
    return 1.6 * fractal_noise(x / 11, z / 11, 5, 0.42, 3) *
           (0.35 + 0.65 * glm::smoothstep(3.0, 16.0, std::hypot(x, z)));
}

Shape terrain(int cells) {
    Shape shape = ground(half_size, half_size, cells, cells);
    for (glm::vec3& p : shape.positions) p.y = static_cast<float>(terrain_height(p.x, p.z));
    return shape;
}

glm::dvec3 across(const glm::dvec3& axis) {
    return glm::normalize(
        glm::cross(axis, std::abs(axis.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0)));
}

// A pointed oval on its stalk, folded along the rib: one sheet, since light meets both sides of a triangle.
void add_leaf(Shape& leaves, const glm::dvec3& foot, const glm::dvec3& along, const glm::dvec3& side,
              double length) {
    const glm::dvec3 up = glm::cross(side, along);
    const auto first = static_cast<uint32_t>(leaves.positions.size());
    const double width = 0.27 * length, fold = 0.10 * length;
    const auto add = [&](double forwards, double sideways, double upwards) {
        leaves.positions.emplace_back(foot + forwards * length * along + sideways * width * side +
                                      upwards * fold * up);
    };
    add(0, 0, 0);
    add(0.3, 1, 1);
    add(0.7, 0.8, 0.6);
    add(1, 0, -0.6);
    add(0.7, -0.8, 0.6);
    add(0.3, -1, 1);
    for (uint32_t k = 1; k <= 4; ++k)
        leaves.indices.insert(leaves.indices.end(), {first, first + k, first + k + 1});
}

enum class Foliage { leaves, cards };

class TreeGrower {
  public:
    TreeGrower(uint32_t seed, Foliage kind)
        : random_(seed), kind_(kind), deepest_(kind == Foliage::leaves ? 3 : 2) {}

    void grow(double height) { branch({0, -0.3, 0}, {0, 1, 0}, height, 0.036 * height, 0); }
    std::vector<std::pair<Shape, int>> take() {
        return {{std::move(wood_), bark}, {std::move(leaves_), foliage}};
    }

  private:
    // A branch bends a little in every one of its pieces.
    void branch(glm::dvec3 from, glm::dvec3 axis, double length, double radius, int level) {
        constexpr int pieces = 3;
        constexpr std::array<int, 3> children{4, 4, 3};  // per piece, from the second on
        for (int piece = 0; piece < pieces; ++piece) {
            const double thin = radius * (1 - 0.25 * piece);
            const glm::dvec3 to = from + axis * (length / pieces);
            wood_.append(rod(from - 0.3 * thin * axis, to, thin, level == 0 ? 10 : level == 1 ? 6 : 3));
            if (level < deepest_) {
                for (int i = 0; piece > 0 && i < children[static_cast<size_t>(level)]; ++i) {
                    const double turn = random_.in(0, glm::two_pi<double>()), lean = random_.in(0.6, 1.15);
                    const glm::dvec3 x = across(axis), y = glm::cross(axis, x);
                    const glm::dvec3 out = std::cos(turn) * x + std::sin(turn) * y;
                    branch(glm::mix(from, to, random_.in(0.2, 1)),
                           glm::normalize(std::cos(lean) * axis + std::sin(lean) * out),
                           length * random_.in(0.38, 0.55), 0.5 * thin, level + 1);
                }
            } else {
                for (int i = 0; i < (kind_ == Foliage::leaves ? 3 : 2); ++i)
                    sprout(glm::mix(from, to, random_.in(0, 1)), axis);
            }
            from = to;
            axis = glm::normalize(
                axis + glm::dvec3(random_.in(-0.16, 0.16), random_.in(-0.06, 0.14), random_.in(-0.16, 0.16)));
        }
    }

    void sprout(const glm::dvec3& foot, const glm::dvec3& axis) {
        const glm::dvec3 along =
            glm::normalize(axis + glm::dvec3(random_.in(-1, 1), random_.in(-0.9, 0.4), random_.in(-1, 1)));
        const glm::dvec3 side = glm::normalize(across(along) + glm::dvec3(0, random_.in(-0.7, 0.7), 0));
        const glm::dvec3 across_leaf = glm::normalize(side - along * glm::dot(side, along));
        if (kind_ == Foliage::leaves)
            add_leaf(leaves_, foot, along, across_leaf, random_.in(0.16, 0.27));
        else
            add_leaf_card(leaves_, foot, along, across_leaf, random_.in(0.5, 0.8));
    }

    SceneRandom random_;
    Foliage kind_;
    int deepest_;  // level of the branches that carry the leaves
    Shape wood_, leaves_;
};

Model forest(ModelBuilder builder, Foliage kind, int ground_cells) {
    builder.solid("terrain", terrain(ground_cells), soil);
    std::array<int, 3> kinds{};
    constexpr std::array<double, 3> heights{4.6, 5.6, 3.9};
    for (uint32_t i = 0; i < kinds.size(); ++i) {
        TreeGrower grower(17 + i, kind);
        grower.grow(heights[i]);
        kinds[i] = builder.mesh(grower.take());
    }
    constexpr std::array<glm::dvec2, 7> places{
        {{-4, -3}, {3.5, -5.5}, {-8.5, -9}, {8.5, -1}, {0, -12}, {9, -12}, {6.5, 5}}};
    for (size_t i = 0; i < places.size(); ++i) {
        builder.node("tree_" + std::to_string(i), kinds[i % kinds.size()],
                     {places[i].x, terrain_height(places[i].x, places[i].y), places[i].y});
    }
    return builder.take();
}

constexpr Material soil_material{{0.20f, 0.21f, 0.11f, 1}}, bark_material{{0.26f, 0.19f, 0.13f, 1}};

}  // namespace

Model make_trees() {
    return forest(ModelBuilder({soil_material, bark_material, {{0.16f, 0.30f, 0.09f, 1}}}), Foliage::leaves,
                  150);
}

Model make_cards() {
    const Material leaves{{1, 1, 1, 1}, 0, leaf_card_cutoff};
    return forest(ModelBuilder({soil_material, bark_material, leaves}, {leaf_card_texture()}), Foliage::cards,
                  60);
}

}  // namespace penumbra
