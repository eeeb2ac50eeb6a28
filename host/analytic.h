// SPDX-License-Identifier: MIT
// Scenes whose visibility is known in closed form. They go through the whole pipeline as real geometry under
// a camera of their own: the receiver is the plane z = 0, seen along -z by an orthographic camera whose
// pixels all span the same length, and what casts the shadow hangs behind the camera.
//
// Half-plane: an opaque sheet at a constant height with one straight edge in view, so high that the penumbra
// is as wide as the shot says. A point of the receiver and the edge span a plane, which cuts the sun along a
// great circle.
#pragma once

#include <optional>
#include <vector>

#include "host/model.h"
#include "host/shot.h"

namespace penumbra {

constexpr double analytic_pixel_m = 1.0 / 64;

// Share of a sun of angular radius `radius` (radians) that lies on the open side of a great circle at signed
// angular distance `distance` from its centre; positive: the centre is on the open side. Both areas are those
// of the sphere.
double half_plane_visibility(double distance, double radius);

// Where everything stands, in metres.
struct HalfPlaneGeometry {
    glm::dvec2 normal{1, 0};  // in the receiver's plane, across the edge, towards the light
    double height = 0;        // of the sheet
    double edge = 0;          // along `normal`, from the image's centre, at the frame asked for
};
HalfPlaneGeometry half_plane_geometry(const Shot& shot, double frame);

// The shot's sheet moves like any object: fills shot.objects. Call once, when the shot is otherwise complete.
void add_half_plane_motion(Shot& shot);

Model half_plane_model(const Shot& shot);
Camera half_plane_camera(const Shot& shot);

// Exact visibility at every pixel's centre, rows from the top.
std::vector<double> half_plane_image(const Shot& shot, double frame);

// Why no such scene exists under this sun at this frame; nothing where it does.
std::optional<std::string> half_plane_problem(const Shot& shot, double frame);

}  // namespace penumbra
