// SPDX-License-Identifier: MIT
#include "host/scene/scene_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/images/input_limit.h"
#include "host/models/joined_models.h"
#include "host/models/shapes.h"
#include "host/truth/analytic.h"

namespace penumbra {
namespace {

void add_ground(Model& model, const Ground& ground) {
    Shape shape = penumbra::ground(ground.half_extent, ground.half_extent, 32, 32);
    const int material = static_cast<int>(model.materials.size());
    model.materials.push_back({.base_color = {0.3f, 0.3f, 0.3f, 1}});
    model.meshes.emplace_back().parts.push_back(to_part(std::move(shape), material));
    Node& node = model.nodes.emplace_back();
    node.name = ground_name;
    node.mesh = static_cast<int>(model.meshes.size()) - 1;
    node.translation = {ground.center[0], ground.height, ground.center[1]};
}

// A triangle of the tree: its corners, its leaf, its share of the nodes above.
constexpr uint64_t bytes_per_triangle = 128;

// A mesh is there once per node that shows it: a file of a thousand nodes and one mesh is a thousand meshes.
uint64_t instance_bytes(const Model& model) {
    std::vector<uint64_t> triangles;
    for (const Mesh& mesh : model.meshes) {
        uint64_t& count = triangles.emplace_back();
        for (const Part& part : mesh.parts) count += part.indices.size() / 3;
    }
    uint64_t bytes = 0;
    for (const Node& node : model.nodes)
        if (node.mesh >= 0) bytes += triangles[static_cast<size_t>(node.mesh)] * bytes_per_triangle;
    return bytes;
}

}  // namespace

std::optional<Scene> load_scene(const Shot& shot, Diagnostics& diagnostics,
                                std::vector<std::string>& warnings) {
    std::optional<Model> model = shot.analytic ? analytic_model(shot) : load_models(shot, diagnostics);
    if (!model) return std::nullopt;
    const std::string name = (shot.model.empty() ? shot.file : shot.model).string();
    if (!check_objects(shot, *model, diagnostics)) return std::nullopt;
    if (const uint64_t bytes = instance_bytes(*model); bytes > input_limit()) {
        diagnostics.add({name}, "",
                        fmt::format("its nodes show {} triangles, which take {}", bytes / bytes_per_triangle,
                                    over_input_limit()));
        return std::nullopt;
    }
    try {
        find_animation(*model, shot.animation);
    } catch (const std::runtime_error& error) {
        diagnostics.add({shot.file.string(), 0, 0}, "animation", error.what());
        return std::nullopt;
    }
    warnings.insert(warnings.end(), model->warnings.begin(), model->warnings.end());
    if (shot.ground) add_ground(*model, *shot.ground);
    Scene scene(std::move(*model), shot);
    if (const size_t dropped = scene.dropped_instances()) {
        const bool one = dropped == 1;
        warnings.push_back(fmt::format(
            "{}: {} that {} scaled to a line or a point, or beyond all numbers, {} not shown", name,
            one ? "1 node" : fmt::format("{} nodes", dropped), one ? "is" : "are", one ? "is" : "are"));
    }
    return scene;
}

}  // namespace penumbra
