// SPDX-License-Identifier: MIT
// Clumps of leaves over a bumpy floor: opaque sheets of their own outline, or cards with an alpha-tested
// picture. What is behind many small edges is neither an edge nor a disc.
#include "host/generated/leaf_card.h"
#include "host/generated/tuning/families.h"
#include "host/generated/tuning/placing.h"

namespace penumbra::tuning {

namespace {

enum class Foliage { leaves, cards };
enum MaterialIndex { soil, bark, green };

// A rhombus that is folded along its rib.
void add_leaf(Shape& leaves, const glm::dvec3& foot, const glm::dmat3& axes, double length) {
    const auto first = static_cast<uint32_t>(leaves.positions.size());
    for (const glm::dvec3& p : {glm::dvec3(0, 0, 0), glm::dvec3(0.3, 0.45, 0.1), glm::dvec3(0, 1, -0.05),
                                glm::dvec3(-0.3, 0.45, 0.1)})
        leaves.positions.emplace_back(foot + length * (axes * p));
    leaves.indices.insert(leaves.indices.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
}

// About the origin, denser in the middle.
Shape clump(Foliage kind, double radius, double leaf, int count, SceneRandom& random) {
    Shape shape;
    for (int i = 0; i < count; ++i) {
        const glm::dmat3 axes(any_rotation(random));
        const glm::dmat3 where(any_rotation(random));
        const glm::dvec3 foot =
            where[1] * radius * (i % 3 == 0 ? random.in(0, 0.6) : random.in(0.4, 1)) * glm::dvec3(1, 0.7, 1);
        const double length = leaf * random.in(0.6, 1.4);
        if (kind == Foliage::leaves)
            add_leaf(shape, foot, axes, length);
        else
            add_leaf_card(shape, foot, axes[1], axes[0], 3 * length);
    }
    return shape;
}

void build_foliage(const Setting& setting, Stage& stage, Foliage kind) {
    SceneRandom random(setting.seed);
    const Material soil_material{{0.20f, 0.21f, 0.11f, 1}}, bark_material{{0.26f, 0.19f, 0.13f, 1}};
    stage.builder = kind == Foliage::leaves
                        ? ModelBuilder({soil_material, bark_material, {{0.16f, 0.30f, 0.09f, 1}}})
                        : ModelBuilder({soil_material, bark_material, {{1, 1, 1, 1}, 0, leaf_card_cutoff}},
                                       {leaf_card_texture()});
    const double distance = setting.distance_m, bumps = 0.03 * distance;
    const uint32_t noise = static_cast<uint32_t>(random.in(0, 1 << 20));
    const auto height = [&](double x, double z) {
        return bumps * fractal_noise(8 * x / distance, 8 * z / distance, 3, 0.4, noise);
    };
    Shape floor = ground(1.6 * distance, 1.6 * distance, 120, 120);
    for (glm::vec3& p : floor.positions) p.y = static_cast<float>(height(p.x, p.z));
    stage.builder.solid("floor", std::move(floor), soil);

    Shape stems;
    for (int i = 0; i < 12; ++i) {
        const glm::dvec3 receiver = floor_point(setting, random);
        const glm::dvec3 place = setting.above(receiver, caster_way(setting, random));
        const double radius = distance * random.in(0.05, 0.12),
                     leaf = distance * between(0.004, 0.02, random);
        Shape shape = clump(kind, radius, leaf, kind == Foliage::leaves ? 800 : 120, random);
        if (i < 2)
            stage.add_movable(std::move(shape), green, place);
        else
            stage.builder.solid("clump_" + std::to_string(i), moved(std::move(shape), glm::dmat4(1), place),
                                green);
        const double root = height(place.x, place.z) - 0.1 * bumps;
        if (place.y > root + 0.01 * distance)
            stems.append(rod({place.x, root, place.z}, place, 0.004 * distance, 7));
    }
    stage.builder.solid("stems", std::move(stems), bark);
}

}  // namespace

void build_leaves(const Setting& setting, Stage& stage) {
    build_foliage(setting, stage, Foliage::leaves);
}

void build_cards(const Setting& setting, Stage& stage) {
    build_foliage(setting, stage, Foliage::cards);
}

}  // namespace penumbra::tuning
