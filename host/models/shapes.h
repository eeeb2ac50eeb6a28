// SPDX-License-Identifier: MIT
// Solid shapes as triangles, wound counter-clockwise seen from outside. Enough to build test scenes from.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "host/models/model.h"

namespace penumbra {

struct Shape {
    std::vector<glm::vec3> positions;
    std::vector<uint32_t> indices;
    std::vector<glm::vec2> uv{};  // as many as positions, or none

    void append(const Shape& other);
    void transform(const glm::dmat4& matrix);
};

Shape box(const glm::dvec3& low, const glm::dvec3& high);

// A horizontal rectangle at height 0, facing up, cut into cells: long thin or huge triangles lose depth
// precision.
Shape ground(double half_x, double half_z, int cells_x, int cells_z);

struct ProfilePoint {
    double height, radius;
};

// A closed solid of revolution about +y; `ripple(angle)` scales the radius (1: round). Closed by caps at both
// ends.
Shape lathe(std::span<const ProfilePoint> profile, int segments,
            const std::function<double(double)>& ripple = {});

// A straight round bar from `a` to `b`.
Shape rod(const glm::dvec3& a, const glm::dvec3& b, double radius, int segments);

// A ring in the x-y plane about the origin, stretched along x by `straight` (an oval chain link).
Shape link(double ring_radius, double bar_radius, double straight, int ring_segments, int bar_segments);

// Links from `a` to `b` hung as a parabola that sags by `sag` metres, every other one turned by 90 degrees.
Shape chain(const glm::dvec3& a, const glm::dvec3& b, double sag, double bar_radius);

// The shape as a part of a mesh, untouched (add_part() would drop and move; shapes need neither).
Part to_part(Shape shape, int material);

}  // namespace penumbra
