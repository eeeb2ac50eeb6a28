// SPDX-License-Identifier: MIT
// The boxes of the tree's nodes (host/bvh/bvh.h) in double precision, and cones that may touch them.
#pragma once

#include <bit>
#include <cmath>
#include <glm/glm.hpp>

#include "host/bvh/bvh.h"

namespace penumbra {

struct TreeBox {
    glm::dvec3 lo, hi;
};

// Of child `k` of the node whose three texels start at `node`.
inline TreeBox child_box(const Texel* node, uint32_t k) {
    const uint32_t planes[3][2] = {
        {node[1][2], node[1][3]}, {node[2][0], node[2][1]}, {node[2][2], node[2][3]}};
    TreeBox box{};
    for (int a = 0; a < 3; ++a) {
        const double origin = std::bit_cast<float>(node[0][a]),
                     step = std::ldexp(1.0, static_cast<int>(node[0][3] >> (8 * a) & 255) - 127);
        box.lo[a] = origin + step * (planes[a][0] >> (8 * k) & 255);
        box.hi[a] = origin + step * (planes[a][1] >> (8 * k) & 255);
    }
    return box;
}

// Of a start, an axis and a half angle: whether it may touch a box. The sphere around the box stands for it.
struct TreeCone {
    glm::dvec3 start, axis;  // axis: unit
    double cosine, sine;
    double radius = 0;  // of the cone's start: a cylinder where the angle is 0

    bool may_touch(const TreeBox& box) const {
        const double around = radius + 0.5 * glm::length(box.hi - box.lo);
        const glm::dvec3 to = 0.5 * (box.lo + box.hi) - start;
        const double along = glm::dot(to, axis), across = glm::length(to - along * axis);
        return along >= -around && across * cosine - along * sine <= around;
    }
};

}  // namespace penumbra
