// SPDX-License-Identifier: MIT
// A model at a moment of one of its animations: where its nodes stand, and where the vertices of what
// deforms.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "host/models/model.h"

namespace penumbra {

// Local values of a node, as the file has them or as an animation says.
struct NodePose {
    glm::dvec3 translation{0};
    glm::dquat rotation{1, 0, 0, 0};
    glm::dvec3 scale{1};
    std::vector<double> weights;  // of morph targets
};

// All nodes at `seconds`; before the first key and after the last one that is held. `animation` -1: at rest.
std::vector<NodePose> pose_at(const Model& model, int animation, double seconds);

// Vertices of a part that deforms, relative to the part's origin: in the node's frame; with a skin, in that
// which `joints` lead to, world * inverse bind of each for the scene's. Without a skin there are none.
std::vector<glm::vec3> deformed_positions(const Part& part, const std::vector<double>& weights,
                                          const std::vector<glm::dmat4>& joints);

}  // namespace penumbra
