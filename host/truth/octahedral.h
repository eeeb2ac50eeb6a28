// SPDX-License-Identifier: MIT
// A unit vector from two numbers: the faces of an octahedron, the lower four folded out over the square's
// corners, as shaders/common/receiver_normal.glsl keeps them.
#pragma once

#include <array>
#include <cmath>
#include <glm/glm.hpp>

namespace penumbra {

inline glm::dvec3 octahedral_normal(const std::array<float, 2>& e) {
    glm::dvec3 n(e[0], e[1], 1 - std::abs(double(e[0])) - std::abs(double(e[1])));
    const double fold = std::max(-n.z, 0.0);
    n.x -= std::copysign(fold, n.x);
    n.y -= std::copysign(fold, n.y);
    return glm::normalize(n);
}

}  // namespace penumbra
