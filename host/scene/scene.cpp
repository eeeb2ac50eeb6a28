// SPDX-License-Identifier: MIT
// Transforms down the tree in double precision, and triangles rounded once, relative to an origin nearby.
#include "host/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

namespace penumbra {

namespace {

glm::dmat4 local_transform(const Node& node, const ObjectKey& key) {
    if (node.matrix) return *node.matrix;
    glm::dmat4 local =
        glm::translate(glm::dmat4(1), node.translation + key.translation) * glm::mat4_cast(node.rotation);
    local = glm::rotate(local, glm::radians(key.rotation_deg.x), glm::dvec3(1, 0, 0));
    local = glm::rotate(local, glm::radians(key.rotation_deg.y), glm::dvec3(0, 1, 0));
    local = glm::rotate(local, glm::radians(key.rotation_deg.z), glm::dvec3(0, 0, 1));
    return glm::scale(local, node.scale);
}

bool shows_something(const glm::dmat4& world) {
    const double determinant = glm::determinant(glm::dmat3(world));
    double largest = 0;
    for (int c = 0; c < 3; ++c) largest = std::max(largest, glm::length(glm::dvec3(world[c])));
    // Flattened to a relative thickness below fp32's resolution, or NaN.
    return std::abs(determinant) > 1e-7 * largest * largest * largest && std::isfinite(determinant) &&
           glm::length(glm::dvec3(world[3])) < 1e18;
}

}  // namespace

Scene::Scene(Model model, const Shot& shot) : model_(std::move(model)), objects_(shot.objects) {
    for (const Node& node : model_.nodes) {
        const auto found = objects_.find(node.name);
        motions_.push_back(found == objects_.end() ? nullptr : &found->second);
    }
    for (const Mesh& mesh : model_.meshes) {
        std::array<glm::dvec3, 2>& box = mesh_boxes_.emplace_back();
        box = {glm::dvec3(INFINITY), glm::dvec3(-INFINITY)};
        for (const Part& part : mesh.parts) {
            for (const glm::vec3& p : part.positions) {
                box[0] = glm::min(box[0], part.origin + glm::dvec3(p));
                box[1] = glm::max(box[1], part.origin + glm::dvec3(p));
            }
        }
    }
    const std::vector<glm::dmat4> world = transforms(0);
    glm::dvec3 low(INFINITY), high(-INFINITY);
    for (size_t i = 0; i < model_.nodes.size(); ++i) {
        const int mesh = model_.nodes[i].mesh;
        if (mesh < 0 || model_.meshes[static_cast<size_t>(mesh)].parts.empty()) continue;
        if (!shows_something(world[i])) {
            ++dropped_instances_;
            continue;
        }
        instances_.push_back({static_cast<int>(i), mesh});
        for (const Part& part : model_.meshes[static_cast<size_t>(mesh)].parts) {
            for (const uint32_t index : part.indices) {
                const glm::dvec3 p(world[i] * glm::dvec4(part.origin + glm::dvec3(part.positions[index]), 1));
                low = glm::min(low, p);
                high = glm::max(high, p);
            }
        }
    }
    if (instances_.empty()) return;
    bounds_ = {low, high};
    bvh_origin_ = 0.5 * (low + high);
}

std::vector<glm::dmat4> Scene::transforms(double frame) const {
    std::vector<glm::dmat4> world(model_.nodes.size());
    for (size_t i = 0; i < world.size(); ++i) {
        const Node& node = model_.nodes[i];
        world[i] = local_transform(node, motions_[i] ? object_at(*motions_[i], frame) : ObjectKey{});
        if (node.parent >= 0) world[i] = world[static_cast<size_t>(node.parent)] * world[i];
    }
    return world;
}

bool Scene::moved(double a, double b) const {
    return std::ranges::any_of(motions_, [&](const ObjectMotion* motion) {
        if (!motion) return false;
        const ObjectKey at_a = object_at(*motion, a), at_b = object_at(*motion, b);
        return at_a.translation != at_b.translation || at_a.rotation_deg != at_b.rotation_deg;
    });
}

std::array<glm::dvec3, 2> Scene::box(double frame) const {
    const std::vector<glm::dmat4> world = transforms(frame);
    std::array<glm::dvec3, 2> out{glm::dvec3(INFINITY), glm::dvec3(-INFINITY)};
    for (const Instance& instance : instances_) {
        const auto& [low, high] = mesh_boxes_[static_cast<size_t>(instance.mesh)];
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 local(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                                   corner & 4 ? high.z : low.z);
            const glm::dvec3 p(world[static_cast<size_t>(instance.node)] * glm::dvec4(local, 1));
            out = {glm::min(out[0], p), glm::max(out[1], p)};
        }
    }
    return out;
}

std::vector<Triangle> Scene::triangles(double frame) const {
    const std::vector<glm::dmat4> world = transforms(frame);
    std::vector<Triangle> out;
    std::vector<glm::vec3> moved_positions;
    for (const Instance& instance : instances_) {
        const glm::dmat4& transform = world[static_cast<size_t>(instance.node)];
        for (const Part& part : model_.meshes[static_cast<size_t>(instance.mesh)].parts) {
            moved_positions.clear();
            for (const glm::vec3& p : part.positions) {
                const glm::dvec3 at(transform * glm::dvec4(part.origin + glm::dvec3(p), 1));
                moved_positions.emplace_back(at - bvh_origin_);
            }
            for (size_t i = 0; i < part.indices.size(); i += 3) {
                Triangle& triangle = out.emplace_back();
                for (size_t corner = 0; corner < 3; ++corner) {
                    const glm::vec3& p = moved_positions[part.indices[i + corner]];
                    for (int axis = 0; axis < 3; ++axis) triangle.v[corner][axis] = p[axis];
                }
            }
        }
    }
    return out;
}

std::vector<uint32_t> Scene::triangle_objects() const {
    std::vector<uint32_t> objects;
    for (size_t i = 0; i < instances_.size(); ++i) {
        for (const Part& part : model_.meshes[static_cast<size_t>(instances_[i].mesh)].parts) {
            objects.insert(objects.end(), part.indices.size() / 3, static_cast<uint32_t>(i));
        }
    }
    return objects;
}

}  // namespace penumbra
