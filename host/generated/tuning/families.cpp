// SPDX-License-Identifier: MIT
#include "host/generated/tuning/families.h"

#include <cmath>

namespace penumbra::tuning {

namespace {

// Sines differ in the last bit between mathematical libraries, and products that are added between
// processors; a grid of 61 micrometres knows of neither.
constexpr double grid = 0x1p14;

double snapped(double x) {
    return std::round(x * grid) / grid + 0.0;  // no negative zero
}

}  // namespace

void snap(Model& model) {
    for (Node& node : model.nodes)
        for (int i = 0; i < 3; ++i) node.translation[i] = snapped(node.translation[i]);
    for (Mesh& mesh : model.meshes)
        for (Part& part : mesh.parts)
            for (glm::vec3& p : part.positions)
                for (int i = 0; i < 3; ++i) p[i] = static_cast<float>(snapped(p[i]));
}

void Stage::add_movable(Shape shape, int material, const glm::dvec3& place) {
    movable.push_back("moved_" + std::to_string(movable.size()));
    builder.node(movable.back(), builder.mesh(std::move(shape), material), place);
}

TuningScene make_tuning_scene(const Family& family, uint32_t seed) {
    const std::string name = std::string(family.name) + "_" + std::to_string(seed);
    TuningScene scene{name, make_setting(family.ranges, seed), {}, {}};
    Stage stage{ModelBuilder({})};
    family.build(scene.setting, stage);
    scene.model = stage.builder.take();
    snap(scene.model);
    scene.shot = shot_text(scene.setting, name + ".glb", stage.movable);
    return scene;
}

}  // namespace penumbra::tuning
