// SPDX-License-Identifier: MIT
#include "host/models/joined_models.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <span>

#include "host/models/gltf.h"

namespace penumbra {
namespace {

template <class T>
void append(std::vector<T>& all, std::vector<T>& more) {
    std::move(more.begin(), more.end(), std::back_inserter(all));
}

// Indices that say "none" by -1 stay so.
void shift(int& index, size_t by) {
    if (index >= 0) index += static_cast<int>(by);
}

glm::dquat rotation_of(const glm::dvec3& degrees) {
    const glm::dvec3 angle = glm::radians(degrees);
    return glm::angleAxis(angle.x, glm::dvec3(1, 0, 0)) * glm::angleAxis(angle.y, glm::dvec3(0, 1, 0)) *
           glm::angleAxis(angle.z, glm::dvec3(0, 0, 1));
}

// The models of the project's own shots are in no clone.
std::optional<Model> load_one(const std::filesystem::path& file, Diagnostics& diagnostics) {
    std::error_code unknown;
    if (!std::filesystem::exists(file, unknown) &&
        std::filesystem::exists(file.parent_path() / "../scripts/scenes.sh", unknown)) {
        diagnostics.add(
            {file.string(), 0, 0}, "",
            "no such file; `scripts/scenes.sh release` puts the models of the shots that ship there");
        return std::nullopt;
    }
    return load_gltf(file, diagnostics);
}

}  // namespace

void join_model(Model& all, Model model, const PlacedModel& place) {
    const std::string before = place.name + "/";
    Node& root = all.nodes.emplace_back();
    root.name = place.name;
    root.translation = place.place.translation;
    root.rotation = rotation_of(place.place.rotation_deg);
    root.scale = glm::dvec3(place.scale);

    const size_t nodes = all.nodes.size(), meshes = all.meshes.size(), materials = all.materials.size(),
                 textures = all.textures.size(), skins = all.skins.size();
    for (Node& node : model.nodes) {
        node.parent = static_cast<int>(nodes) + (node.parent < 0 ? -1 : node.parent);
        shift(node.mesh, meshes);
        shift(node.skin, skins);
        shift(node.weights_of, nodes);
        node.name = before + node.name;
    }
    for (Mesh& mesh : model.meshes)
        for (Part& part : mesh.parts) shift(part.material, materials);
    for (Material& material : model.materials) {
        shift(material.texture, textures);
        shift(material.metallic_roughness_texture, textures);
        shift(material.emissive_texture, textures);
        shift(material.transmission_texture, textures);
    }
    for (Skin& skin : model.skins)
        for (int& joint : skin.joints) shift(joint, nodes);
    for (Animation& animation : model.animations) {
        animation.name = before + animation.name;
        for (AnimationChannel& channel : animation.channels) shift(channel.node, nodes);
    }
    for (ModelCamera& camera : model.cameras) shift(camera.node, nodes);
    for (int& sun : model.suns) shift(sun, nodes);
    for (ModelLight& light : model.lights) {
        shift(light.node, nodes);
        light.name = before + light.name;
    }
    for (std::string& warning : model.warnings) warning = place.file.string() + ": " + warning;

    append(all.nodes, model.nodes);
    append(all.meshes, model.meshes);
    append(all.materials, model.materials);
    append(all.textures, model.textures);
    append(all.skins, model.skins);
    append(all.animations, model.animations);
    append(all.cameras, model.cameras);
    append(all.suns, model.suns);
    append(all.lights, model.lights);
    for (std::string& warning : model.warnings)  // a file that stands in many places says it once
        if (std::ranges::find(all.warnings, warning) == all.warnings.end())
            all.warnings.push_back(std::move(warning));
    all.dropped_degenerate += model.dropped_degenerate;
    all.dropped_nonfinite += model.dropped_nonfinite;
}

std::optional<Model> load_models(const Shot& shot, Diagnostics& diagnostics) {
    if (shot.analytic) return std::nullopt;
    std::optional<Model> all;
    if (shot.models.empty()) {
        all = load_one(shot.model, diagnostics);
        if (!all) return std::nullopt;
        for (std::string& warning : all->warnings) warning = shot.model.string() + ": " + warning;
    } else {
        all.emplace();
        std::map<std::filesystem::path, Model> read;  // what stands in further places
        for (size_t i = 0; i < shot.models.size(); ++i) {
            const PlacedModel& place = shot.models[i];
            auto known = read.extract(place.file);
            std::optional<Model> model =
                known ? std::optional(std::move(known.mapped())) : load_one(place.file, diagnostics);
            if (!model) return std::nullopt;
            const auto rest = std::span(shot.models).subspan(i + 1);
            if (std::ranges::find(rest, place.file, &PlacedModel::file) != rest.end())
                read.emplace(place.file, *model);
            join_model(*all, std::move(*model), place);
        }
    }
    if (all->triangle_count() == 0) {
        diagnostics.add({}, "", fmt::format("{}", fmt::join(all->warnings, "; ")));
        return std::nullopt;
    }
    return all;
}

}  // namespace penumbra
