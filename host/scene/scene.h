// SPDX-License-Identifier: MIT
// A model in motion: where each mesh stands in each frame of a shot, and its triangles for the BVH. World
// positions here leave out the shot's origin; whoever subtracts a camera adds it, in double precision.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "host/bvh/bvh.h"
#include "host/models/model.h"
#include "host/scene/pose.h"
#include "host/shots/shot.h"

namespace penumbra {

// One mesh at one node.
struct Instance {
    int node = -1;
    int mesh = -1;
};

class Scene {
  public:
    // check_objects() must have passed.
    Scene(Model model, const Shot& shot);
    Scene(Scene&&) = default;
    Scene(const Scene&) = delete;  // motions_ points into objects_
    Scene& operator=(const Scene&) = delete;

    const Model& model() const { return model_; }
    // Nodes with a mesh. Those that are a line or a point and stay so, and those that are not finite, show
    // nothing and are left out (and counted); what an animation moves may become something.
    const std::vector<Instance>& instances() const { return instances_; }
    int dropped_instances() const { return dropped_instances_; }

    // World transforms of all nodes at a frame, without the shot's origin. Of nodes with a skin the way to
    // its first joint: the joints put the vertices where they are. Of flat meshes one with an inverse.
    std::vector<glm::dmat4> transforms(double frame) const;
    // Whether a part's vertices move in its instance's frame.
    bool deforms(const Instance& instance, const Part& part) const;
    // All nodes at a frame.
    struct Pose {
        std::vector<NodePose> nodes;
        std::vector<glm::dmat4> world;  // of all, with a skin or without
    };
    Pose pose(double frame) const;
    // Vertices of a part, relative to its origin: its own where it does not deform.
    std::vector<glm::vec3> positions(const Instance& instance, const Part& part, const Pose& pose) const;
    std::vector<glm::vec3> positions(const Instance& instance, const Part& part, double frame) const;
    // Whether an animation of the file is played that moves anything.
    bool animated() const;
    // Whether any triangle stands elsewhere at frame b than at frame a.
    bool moved(double a, double b) const;

    // The BVH's frame: world axes about this point, without the shot's origin. It is the centre of the first
    // frame's box; of one of more than half a kilometre in smaller triangles (67 km in any) the place in it
    // where the shot's camera is.
    const glm::dvec3& bvh_origin() const { return bvh_origin_; }
    // All triangles relative to bvh_origin(), instance by instance; the count and the order never change. Of
    // translucent ones, which block no ray, all corners are at the first, so that no tree holds them.
    std::vector<Triangle> triangles(double frame) const;
    // The translucent ones alone, in the same order.
    std::vector<Triangle> translucent_triangles(double frame) const;
    // Per triangle, the index of its instance: what build_bvh() calls its object.
    std::vector<uint32_t> triangle_objects() const;
    size_t triangle_count() const;
    // Whether a part lets light through (host/models/translucency.h), and whether any that is shown does.
    bool translucent(const Part& part) const {
        return part.material >= 0 && translucent_[static_cast<size_t>(part.material)];
    }
    // Of a translucent part, texels that are opaque and are drawn.
    bool has_opaque_texels(const Part& part) const {
        return part.material >= 0 && opaque_texels_[static_cast<size_t>(part.material)];
    }
    bool has_translucent() const;
    // Whether its material's test removes any texel at all.
    bool alpha_tested(const Part& part) const {
        return part.material >= 0 && alpha_tested_[static_cast<size_t>(part.material)];
    }
    // Box of all triangles at the first frame, without the shot's origin.
    const std::array<glm::dvec3, 2>& bounds() const { return bounds_; }
    // A box that holds all triangles at a frame, without the shot's origin; made of the parts' boxes, so not
    // always the tightest.
    std::array<glm::dvec3, 2> box(double frame) const;
    // Around each instance that stands elsewhere at frame b than at frame a, or has another shape, where it
    // is at both; in box()'s frame.
    std::vector<std::array<glm::dvec3, 2>> moved_boxes(double a, double b) const;

  private:
    std::vector<glm::dmat4> transforms(const Pose& pose) const;
    glm::dvec3 skin_origin(const Node& node, const Pose& pose) const;  // where its vertices are counted from
    std::vector<bool> moving_nodes() const;  // of the animation, with what hangs on them
    bool deforms(const Instance& instance) const;
    // `world`: of its node, of transforms().
    std::array<glm::dvec3, 2> box(const Instance& instance, const glm::dmat4& world, const Pose& pose) const;
    // visit(part, corners) of every triangle in order.
    template <class Visit>
    void each_triangle(double frame, const Visit& visit) const;
    const std::vector<Part>& parts(const Instance& instance) const {
        return model_.meshes[static_cast<size_t>(instance.mesh)].parts;
    }

    Model model_;
    std::vector<bool> translucent_, opaque_texels_, alpha_tested_;  // by material
    int animation_ = -1;
    double fps_ = 60;
    std::vector<const ObjectMotion*> motions_;  // per node, null where it stands still
    std::map<std::string, ObjectMotion> objects_;
    std::vector<Instance> instances_;
    int dropped_instances_ = 0;
    glm::dvec3 bvh_origin_{0};
    std::array<glm::dvec3, 2> bounds_{};
    std::vector<std::array<glm::dvec3, 2>> mesh_boxes_;
};

}  // namespace penumbra
