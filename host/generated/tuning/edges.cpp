// SPDX-License-Identifier: MIT
// Straight edges in every direction: bars in the air, blocks on the floor, and a ramp that the light grazes.
#include "host/generated/tuning/families.h"
#include "host/generated/tuning/placing.h"

namespace penumbra::tuning {

namespace {

// Its upper face leans away from the sun, so that the light meets it at 4 to 12 degrees.
Shape grazed_ramp(const Setting& setting, SceneRandom& random) {
    const double grazing = glm::radians(random.in(4, 12));
    const glm::dvec3 level = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), setting.to_sun));
    const glm::dvec3 uphill = glm::normalize(glm::cross(setting.to_sun, level));  // across the light, upwards
    const glm::dvec3 normal = std::sin(grazing) * setting.to_sun + std::cos(grazing) * uphill;
    const glm::dmat4 axes(glm::dvec4(level, 0), glm::dvec4(normal, 0),
                          glm::dvec4(glm::cross(level, normal), 0), glm::dvec4(0, 0, 0, 1));
    const double size = setting.distance_m * random.in(0.08, 0.14);
    return moved(bar({size, 0.05 * size, size}), axes,
                 floor_point(setting, random) + glm::dvec3(0, 0.3 * size, 0));
}

}  // namespace

void build_edges(const Setting& setting, Stage& stage) {
    SceneRandom random(setting.seed);
    stage.builder =
        ModelBuilder({{{0.42f, 0.40f, 0.37f, 1}}, {{0.60f, 0.45f, 0.30f, 1}}, {{0.25f, 0.30f, 0.38f, 1}}});
    const double distance = setting.distance_m;
    stage.builder.solid("floor", ground(3 * distance, 3 * distance, 2, 2), 0);
    for (int i = 0; i < 14; ++i) {
        const double thick = distance * between(0.002, 0.015, random);
        const double width = thick * random.in(0.3, 6);
        const glm::dvec3 half(distance * between(0.03, 0.25, random), thick, width);
        Shape shape = moved(bar(half), any_rotation(random), {});
        const glm::dvec3 place = caster_place(setting, random);
        if (i < 4)
            stage.add_movable(std::move(shape), 1, place);
        else
            stage.builder.solid("bar_" + std::to_string(i), moved(std::move(shape), glm::dmat4(1), place), 1);
    }
    for (int i = 0; i < 6; ++i) {
        glm::dvec3 half;
        for (const int axis : {2, 1, 0}) half[axis] = distance * between(0.01, 0.06, random);
        const glm::dvec3 place = floor_point(setting, random) + glm::dvec3(0, half.y, 0);
        stage.builder.solid("block_" + std::to_string(i),
                            moved(bar(half), heading(random.in(0, glm::two_pi<double>())), place), 2);
    }
    for (int i = 0; i < 2; ++i)
        stage.builder.solid("ramp_" + std::to_string(i), grazed_ramp(setting, random), 0);
}

}  // namespace penumbra::tuning
