// SPDX-License-Identifier: MIT
// Puts shapes together to a model: what the generators of the project's own scenes share.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/models/model.h"
#include "host/models/shapes.h"

namespace penumbra {

class ModelBuilder {
  public:
    explicit ModelBuilder(std::vector<Material> materials, std::vector<Texture> textures = {}) {
        model_.materials = std::move(materials);
        model_.textures = std::move(textures);
    }

    // A mesh to place at any number of nodes, from shapes with their materials; returns its index.
    int mesh(std::vector<std::pair<Shape, int>> parts) {
        Mesh& mesh = model_.meshes.emplace_back();
        for (auto& [shape, material] : parts) mesh.parts.push_back(to_part(std::move(shape), material));
        return static_cast<int>(model_.meshes.size()) - 1;
    }
    int mesh(Shape shape, int material) {
        model_.meshes.emplace_back().parts.push_back(to_part(std::move(shape), material));
        return static_cast<int>(model_.meshes.size()) - 1;
    }

    // mesh -1: a joint that moves what hangs on it; returns the node's index, for children.
    int node(const std::string& name, int mesh, const glm::dvec3& translation, int parent = -1) {
        Node& node = model_.nodes.emplace_back();
        node.name = name;
        node.mesh = mesh;
        node.translation = translation;
        node.parent = parent;
        return static_cast<int>(model_.nodes.size()) - 1;
    }
    // One that does not move, given where it stands.
    void solid(const std::string& name, Shape shape, int material) {
        node(name, mesh(std::move(shape), material), {});
    }

    Model take() { return std::move(model_); }

  private:
    Model model_;
};

}  // namespace penumbra
