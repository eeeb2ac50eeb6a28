// SPDX-License-Identifier: MIT
// A height field under a low sun: receivers that the light grazes and that turn away from it, shadows of one
// hill on the next, poles, wires and boxes on them.
#include "host/generated/tuning/families.h"
#include "host/generated/tuning/placing.h"

namespace penumbra::tuning {

void build_hills(const Setting& setting, Stage& stage) {
    SceneRandom random(setting.seed);
    stage.builder =
        ModelBuilder({{{0.36f, 0.40f, 0.22f, 1}}, {{0.35f, 0.37f, 0.38f, 1}}, {{0.50f, 0.28f, 0.21f, 1}}});
    const double distance = setting.distance_m, size = random.in(0.35, 0.7), rise = 0.05 * distance * size;
    const uint32_t noise = static_cast<uint32_t>(random.in(0, 1 << 20));
    const auto height = [&](double x, double z) {
        return rise * fractal_noise(x / (size * distance), z / (size * distance), 5, 0.4, noise);
    };
    const auto on_ground = [&](const glm::dvec3& p) { return glm::dvec3(p.x, height(p.x, p.z), p.z); };
    Shape hills = ground(2.5 * distance, 2.5 * distance, 120, 120);
    for (glm::vec3& p : hills.positions) p.y = static_cast<float>(height(p.x, p.z));
    stage.builder.solid("hills", std::move(hills), 0);

    // Poles in a row across the view with wires from top to top, so high that their tops' shadows have the
    // way of the setting.
    const double pole = setting.caster_m * setting.to_sun.y * 1.5;
    const glm::dvec3 along = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), setting.to_sun));
    const glm::dvec3 start = floor_point(setting, random) * 0.3 + setting.above({0, 0, 0}, setting.caster_m);
    Shape poles, wires;
    glm::dvec3 last(0);
    for (int i = -4; i <= 4; ++i) {
        const glm::dvec3 foot = on_ground(start + along * (i * 0.13 * distance));
        const glm::dvec3 top = foot + glm::dvec3(0, pole, 0);
        poles.append(rod(foot - glm::dvec3(0, 0.2 * pole, 0), top, 0.003 * distance, 8));
        if (i > -4) wires.append(rod(last, top, 0.0007 * distance, 6));
        last = top;
    }
    stage.builder.solid("poles", std::move(poles), 1);
    stage.builder.solid("wires", std::move(wires), 1);

    for (int i = 0; i < 10; ++i) {
        glm::dvec3 half(0);
        for (const int axis : {2, 0}) half[axis] = distance * between(0.008, 0.04, random);
        const double up = 0.5 * caster_way(setting, random) * setting.to_sun.y;
        Shape shape = moved(bar(half + glm::dvec3(0, up, 0)), heading(random.in(0, glm::pi<double>())), {});
        const glm::dvec3 place = on_ground(floor_point(setting, random)) + glm::dvec3(0, 0.6 * up, 0);
        if (i < 3)
            stage.add_movable(std::move(shape), 2, place);
        else
            stage.builder.solid("house_" + std::to_string(i), moved(std::move(shape), glm::dmat4(1), place),
                                2);
    }
}

}  // namespace penumbra::tuning
