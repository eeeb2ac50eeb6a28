// SPDX-License-Identifier: MIT
// The open share of the sun's disc, in closed form: the sun is a cap of the sphere of directions about a
// receiver's point, and so is what a sphere hides of it; straight edges hide up to a great circle. All areas
// are those of the sphere (Gauss-Bonnet), in double precision: single precision loses two digits of three at
// the sun's .27 degrees. Angles are in radians.
#pragma once

#include <glm/vec3.hpp>
#include <span>

namespace penumbra {

// Of a sun of angular radius `radius` behind a straight edge: the edge and the point span a plane, and the
// sun's centre lies `distance` from it, positive on the open side.
double half_plane_visibility(double distance, double radius);

// Behind a sphere of angular radius `sphere` whose centre lies `distance` from the sun's.
double sphere_visibility(double distance, double sphere, double radius);

// Behind a polygon without holes, its corners seen from the point (any length but zero), in either winding;
// no edge may span 180 degrees.
double polygon_visibility(const glm::dvec3& to_sun, double radius, std::span<const glm::dvec3> corners);

}  // namespace penumbra
