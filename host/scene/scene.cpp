// SPDX-License-Identifier: MIT
// Transforms down the tree in double precision, and triangles rounded once, relative to an origin nearby.
#include "host/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "host/models/translucency.h"
#include "host/scene/geometry.h"

namespace penumbra {

namespace {

// The rotation of a polar decomposition, by Newton's iteration (Higham 1986): what translation, rotation and
// scale have made of a matrix comes apart again as they were. A mirror stays with the scale.
glm::dmat3 rotation_of(const glm::dmat3& m) {
    const double determinant = glm::determinant(m);
    if (!(std::abs(determinant) > 0) || !std::isfinite(determinant)) return glm::dmat3(1);
    glm::dmat3 r = determinant < 0 ? -m : m;
    for (int i = 0; i < 64; ++i) {
        const glm::dmat3 next = 0.5 * (r + glm::transpose(glm::inverse(r)));
        double change = 0;
        for (int c = 0; c < 3; ++c) change = std::max(change, glm::length(next[c] - r[c]));
        r = next;
        if (change < 1e-14) break;
    }
    return r;
}

glm::dmat4 local_transform(const Node& node, const NodePose& pose, const ObjectMotion* motion, double frame) {
    if (node.matrix && !motion) return *node.matrix;
    const ObjectKey key = motion ? object_at(*motion, frame) : ObjectKey{};
    const glm::dmat3 linear = node.matrix ? glm::dmat3(*node.matrix) : glm::dmat3(1);
    const glm::dmat3 turned = node.matrix ? rotation_of(linear) : glm::mat3_cast(pose.rotation);
    const glm::dvec3 origin = node.matrix ? glm::dvec3((*node.matrix)[3]) : pose.translation;
    glm::dmat4 local = glm::translate(glm::dmat4(1), origin + key.translation) * glm::dmat4(turned);
    local = glm::rotate(local, glm::radians(key.rotation_deg.x), glm::dvec3(1, 0, 0));
    local = glm::rotate(local, glm::radians(key.rotation_deg.y), glm::dvec3(0, 1, 0));
    local = glm::rotate(local, glm::radians(key.rotation_deg.z), glm::dvec3(0, 0, 1));
    return node.matrix ? local * glm::dmat4(glm::transpose(turned) * linear) : glm::scale(local, pose.scale);
}

double largest_column(const glm::dmat3& m) {
    return std::max({glm::length(m[0]), glm::length(m[1]), glm::length(m[2])});
}

double length_of(const glm::dmat3& m) {
    return std::sqrt(glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]));
}

bool is_within_reach(const glm::dmat4& world) {
    const double sum = glm::determinant(glm::dmat3(world)) + largest_column(glm::dmat3(world));
    return std::isfinite(sum) && glm::length(glm::dvec3(world[3])) < 1e18;
}

// Whether two directions are left in which anything is seen; less than that is rounding.
bool has_area(const glm::dmat3& m) {
    const double largest = largest_column(m);
    return length_of(cofactors(m)) > 1e-12 * largest * largest;
}

// What is flat has sides all the same: normals and the way back into the node's frame need an inverse. So it
// is made a millionth as thick as it is large, which tells its front from its back and is not seen.
glm::dmat4 with_thickness(const glm::dmat4& world) {
    const glm::dmat3 m(world), across = cofactors(m);
    const double area = length_of(across), least = 1e-6 * largest_column(m),
                 determinant = glm::determinant(m);
    if (!has_area(m) || !(std::abs(determinant) < least * area)) return world;
    const bool mirrored = determinant < -1e-9 * least * area;  // by more than rounding
    const glm::dmat3 thick = m + across * ((mirrored ? -least : least) / area);
    return {glm::dvec4(thick[0], 0), glm::dvec4(thick[1], 0), glm::dvec4(thick[2], 0), world[3]};
}

// Where fp32 is finest. Of what is larger than half a kilometre, whose ends are off by more than a hundredth
// of a millimetre, the place in it where the shot's camera is: one stray object far away may not spoil what
// is looked at. Unless a triangle, of so many metres, is as large itself: before the camera it would be off
// by what its corners are, and rays start by no more above it than is lost where they start. Not until two
// millimetres are lost at the ends (67 km) is that the lesser evil.
glm::dvec3 origin_in(const glm::dvec3& low, const glm::dvec3& high, double largest_triangle,
                     const Shot& shot) {
    const glm::dvec3 middle = 0.5 * (low + high), half = high - middle;
    const double most = std::max({half.x, half.y, half.z});
    if (shot.camera.empty() || most <= 250 || (largest_triangle > 500 && most * 0x1p-24 <= 2e-3))
        return middle;
    glm::dvec3 first = shot.camera[0].position, last = first;
    for (const CameraKey& key : shot.camera) {
        first = glm::min(first, key.position);
        last = glm::max(last, key.position);
    }
    return glm::clamp(0.5 * (first + last), low, high);
}

constexpr std::array<glm::dvec3, 2> no_box{glm::dvec3(INFINITY), glm::dvec3(-INFINITY)};

std::array<glm::dvec3, 2> around(const std::array<glm::dvec3, 2>& a, const std::array<glm::dvec3, 2>& b) {
    return {glm::min(a[0], b[0]), glm::max(a[1], b[1])};
}

}  // namespace

Scene::Scene(Model model, const Shot& shot)
    : model_(std::move(model)),
      animation_(find_animation(model_, shot.animation)),
      fps_(shot.fps),
      objects_(shot.objects) {
    for (size_t i = 0; i < model_.materials.size(); ++i) {
        translucent_.push_back(is_translucent(model_, static_cast<int>(i)));
        alpha_tested_.push_back(is_alpha_tested(model_, static_cast<int>(i)));
        opaque_texels_.push_back(translucent_.back() &&
                                 penumbra::has_opaque_texels(model_, model_.materials[i]));
    }
    for (const Node& node : model_.nodes) {
        const auto found = objects_.find(node.name);
        motions_.push_back(found == objects_.end() ? nullptr : &found->second);
    }
    for (const Mesh& mesh : model_.meshes) {
        std::array<glm::dvec3, 2>& box = mesh_boxes_.emplace_back(no_box);
        for (const Part& part : mesh.parts) {
            for (const uint32_t index : part.indices) {  // other vertices are not seen
                const glm::dvec3 p = part.origin + glm::dvec3(part.positions[index]);
                box = {glm::min(box[0], p), glm::max(box[1], p)};
            }
        }
    }
    const Pose first = pose(0);
    const std::vector<glm::dmat4> world = transforms(first);
    const std::vector<bool> moving = moving_nodes();
    glm::dvec3 low(INFINITY), high(-INFINITY);
    double largest_triangle = 0;  // metres along an axis
    for (size_t i = 0; i < model_.nodes.size(); ++i) {
        const int mesh = model_.nodes[i].mesh;
        if (mesh < 0 || model_.meshes[static_cast<size_t>(mesh)].parts.empty()) continue;
        if (!is_within_reach(world[i]) || !(moving[i] || has_area(glm::dmat3(world[i])))) {
            ++dropped_instances_;
            continue;
        }
        instances_.push_back({static_cast<int>(i), mesh});
        const Instance& instance = instances_.back();
        for (const Part& part : parts(instance)) {
            const std::vector<glm::vec3> at = positions(instance, part, first);
            for (size_t t = 0; t + 2 < part.indices.size(); t += 3) {
                glm::dvec3 least(INFINITY), most(-INFINITY);
                for (size_t k = t; k < t + 3; ++k) {
                    const glm::dvec3 local = part.origin + glm::dvec3(at[part.indices[k]]),
                                     p(world[i] * glm::dvec4(local, 1));
                    least = glm::min(least, p);
                    most = glm::max(most, p);
                }
                low = glm::min(low, least);
                high = glm::max(high, most);
                const glm::dvec3 size = most - least;
                largest_triangle = std::max({largest_triangle, size.x, size.y, size.z});
            }
        }
    }
    if (instances_.empty()) return;
    bounds_ = {low, high};
    bvh_origin_ = origin_in(low, high, largest_triangle, shot);
}

std::vector<bool> Scene::moving_nodes() const {
    std::vector<bool> moving(model_.nodes.size());
    if (animation_ >= 0)
        for (const AnimationChannel& channel : model_.animations[static_cast<size_t>(animation_)].channels)
            moving[static_cast<size_t>(channel.node)] = true;
    for (size_t i = 0; i < moving.size(); ++i)  // parents first
        if (const int parent = model_.nodes[i].parent; parent >= 0 && moving[static_cast<size_t>(parent)])
            moving[i] = true;
    return moving;
}

Scene::Pose Scene::pose(double frame) const {
    Pose out{pose_at(model_, animation_, frame / fps_), std::vector<glm::dmat4>(model_.nodes.size())};
    for (size_t i = 0; i < out.world.size(); ++i) {
        const Node& node = model_.nodes[i];
        out.world[i] = local_transform(node, out.nodes[i], motions_[i], frame);
        if (node.parent >= 0) out.world[i] = out.world[static_cast<size_t>(node.parent)] * out.world[i];
    }
    return out;
}

std::vector<glm::dmat4> Scene::transforms(double frame) const {
    return transforms(pose(frame));
}

std::vector<glm::dmat4> Scene::transforms(const Pose& posed) const {
    std::vector<glm::dmat4> world = posed.world;
    for (size_t i = 0; i < world.size(); ++i) {
        const Node& node = model_.nodes[i];
        if (node.skin >= 0)
            world[i] = glm::translate(glm::dmat4(1), skin_origin(node, posed));
        else if (node.mesh >= 0)
            world[i] = with_thickness(world[i]);
    }
    return world;
}

glm::dvec3 Scene::skin_origin(const Node& node, const Pose& pose) const {
    const int joint = model_.skins[static_cast<size_t>(node.skin)].joints[0];
    return pose.world[static_cast<size_t>(joint)][3];
}

bool Scene::deforms(const Instance& instance, const Part& part) const {
    return !part.targets.empty() ||
           (!part.joints.empty() && model_.nodes[static_cast<size_t>(instance.node)].skin >= 0);
}

std::vector<glm::vec3> Scene::positions(const Instance& instance, const Part& part, const Pose& pose) const {
    if (!deforms(instance, part)) return part.positions;
    const auto index = static_cast<size_t>(instance.node);
    const Node& node = model_.nodes[index];
    std::vector<glm::dmat4> joints;
    if (node.skin >= 0) {
        const Skin& skin = model_.skins[static_cast<size_t>(node.skin)];
        const glm::dmat4 to_origin = glm::translate(glm::dmat4(1), -skin_origin(node, pose));
        for (size_t i = 0; i < skin.joints.size(); ++i)
            joints.push_back(to_origin * pose.world[static_cast<size_t>(skin.joints[i])] *
                             skin.inverse_bind[i]);
    }
    return deformed_positions(part, pose.nodes[index].weights, joints);
}

std::vector<glm::vec3> Scene::positions(const Instance& instance, const Part& part, double frame) const {
    return deforms(instance, part) ? positions(instance, part, pose(frame)) : part.positions;
}

bool Scene::animated() const {
    return animation_ >= 0 && !model_.animations[static_cast<size_t>(animation_)].channels.empty();
}

bool Scene::moved(double a, double b) const {
    if (a != b && animated()) return true;
    return std::ranges::any_of(motions_, [&](const ObjectMotion* motion) {
        if (!motion) return false;
        const ObjectKey at_a = object_at(*motion, a), at_b = object_at(*motion, b);
        return at_a.translation != at_b.translation || at_a.rotation_deg != at_b.rotation_deg;
    });
}

bool Scene::deforms(const Instance& instance) const {
    return std::ranges::any_of(parts(instance), [&](const Part& part) { return deforms(instance, part); });
}

std::array<glm::dvec3, 2> Scene::box(const Instance& instance, const glm::dmat4& world,
                                     const Pose& posed) const {
    std::array<glm::dvec3, 2> out = no_box;
    const auto add = [&](const glm::dvec3& local) {
        const glm::dvec3 p(world * glm::dvec4(local, 1));
        out = {glm::min(out[0], p), glm::max(out[1], p)};
    };
    if (deforms(instance)) {
        for (const Part& part : parts(instance)) {
            const std::vector<glm::vec3> at = positions(instance, part, posed);
            for (const uint32_t index : part.indices) add(part.origin + glm::dvec3(at[index]));
        }
        return out;
    }
    const auto& [low, high] = mesh_boxes_[static_cast<size_t>(instance.mesh)];
    for (int corner = 0; corner < 8; ++corner)
        add({corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z});
    return out;
}

std::array<glm::dvec3, 2> Scene::box(double frame) const {
    const Pose posed = pose(frame);
    const std::vector<glm::dmat4> world = transforms(posed);
    std::array<glm::dvec3, 2> out = no_box;
    for (const Instance& instance : instances_)
        out = around(out, box(instance, world[static_cast<size_t>(instance.node)], posed));
    return out;
}

std::vector<std::array<glm::dvec3, 2>> Scene::moved_boxes(double a, double b) const {
    std::vector<std::array<glm::dvec3, 2>> boxes;
    if (!moved(a, b)) return boxes;
    const Pose pose_a = pose(a), pose_b = pose(b);
    const std::vector<glm::dmat4> at_a = transforms(pose_a), at_b = transforms(pose_b);
    for (const Instance& instance : instances_) {
        const auto node = static_cast<size_t>(instance.node);
        if (at_a[node] != at_b[node] || deforms(instance))
            boxes.push_back(around(box(instance, at_a[node], pose_a), box(instance, at_b[node], pose_b)));
    }
    return boxes;
}

bool Scene::has_translucent() const {
    return std::ranges::any_of(instances_, [&](const Instance& instance) {
        return std::ranges::any_of(parts(instance), [&](const Part& part) { return translucent(part); });
    });
}

template <class Visit>
void Scene::each_triangle(double frame, const Visit& visit) const {
    const Pose posed = pose(frame);
    const std::vector<glm::dmat4> world = transforms(posed);
    std::vector<glm::vec3> moved_positions;
    for (const Instance& instance : instances_) {
        const glm::dmat4& transform = world[static_cast<size_t>(instance.node)];
        for (const Part& part : parts(instance)) {
            moved_positions.clear();
            for (const glm::vec3& p : positions(instance, part, posed)) {
                const glm::dvec3 at(transform * glm::dvec4(part.origin + glm::dvec3(p), 1));
                moved_positions.emplace_back(at - bvh_origin_);
            }
            for (size_t i = 0; i < part.indices.size(); i += 3) {
                Triangle triangle{};
                for (size_t corner = 0; corner < 3; ++corner) {
                    const glm::vec3& p = moved_positions[part.indices[i + corner]];
                    for (int axis = 0; axis < 3; ++axis) triangle.v[corner][axis] = p[axis];
                }
                visit(part, triangle);
            }
        }
    }
}

size_t Scene::triangle_count() const {
    size_t count = 0;
    for (const Instance& instance : instances_)
        for (const Part& part : parts(instance)) count += part.indices.size() / 3;
    return count;
}

std::vector<Triangle> Scene::triangles(double frame) const {
    std::vector<Triangle> out;
    out.reserve(triangle_count());
    each_triangle(frame, [&](const Part& part, Triangle& triangle) {
        if (translucent(part))
            for (auto& corner : triangle.v) std::ranges::copy(triangle.v[0], corner);
        out.push_back(triangle);
    });
    return out;
}

std::vector<Triangle> Scene::translucent_triangles(double frame) const {
    std::vector<Triangle> out;
    each_triangle(frame, [&](const Part& part, const Triangle& triangle) {
        if (translucent(part)) out.push_back(triangle);
    });
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
