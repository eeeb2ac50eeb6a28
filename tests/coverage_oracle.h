// SPDX-License-Identifier: MIT
// How much of a round light convex blockers hide, exactly: the area of their union, in double precision.
//
// The union is cut into strips along x at every place where two of the lines or a line and the rim cross. In
// a strip nothing changes its order, so what is covered of a column is a smooth function of x, which Gauss's
// rule integrates to rounding. It shares nothing with masks, samples or rays.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace penumbra::test {

// The part of the light's disc, of radius 1, where all lines are positive: l.x x + l.y y + l.z >= 0.
using ConvexPart = std::vector<glm::dvec3>;

// The light as a receiver sees it: z towards its middle. `angular_radius` in radians, below 1.2.
struct SeenLight {
    glm::dmat3 axes;  // columns x, y, z
    double angular_radius = 0;
};

// Axes of any turn about the unit vector `to_sun`.
SeenLight seen_light(const glm::dvec3& to_sun, double angular_radius);

// What a triangle hides from `start`, wherever its corners are; no lines where it is seen edge-on.
ConvexPart hidden_by(const SeenLight& light, const glm::dvec3& start, const glm::dvec3 (&corners)[3]);

// What lies below the receiver's own plane.
ConvexPart below_plane(const SeenLight& light, const glm::dvec3& normal);

// Share of the light that the union of the parts hides, 0 to 1, within 1e-9 for some hundred lines. Parts of
// no lines hide nothing. The light is uniform over its cap of `angular_radius`; 0: over the flat disc.
double hidden_share(std::span<const ConvexPart> parts, double angular_radius);

}  // namespace penumbra::test
