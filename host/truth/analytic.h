// SPDX-License-Identifier: MIT
// Scenes whose visibility is known in closed form. They go through the whole pipeline as real geometry under
// a camera of their own: the receiver is the plane z = 0 (the terminator's apart), seen along -z by an
// orthographic camera whose pixels all span the same length, and what casts the shadow hangs behind the
// camera, is seen edge-on, or begins above the near plane. Under a tilted half-plane the camera looks at the
// receiver at an angle.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/metrics/contact.h"
#include "host/models/model.h"
#include "host/shots/shot.h"
#include "host/truth/sun_visibility.h"

namespace penumbra {

constexpr double analytic_pixel_m = 1.0 / 64;

// Where everything stands, in metres.
struct AnalyticGeometry {
    glm::dvec2 normal{1, 0};  // in the receiver's plane, across the edge, towards the light
    double height = 0;        // of a hanging sheet or a sphere's centre, or of a wall's top
    double edge = 0;          // along `normal`, from the image's centre, at the frame asked for
    glm::dvec2 centre{0};     // where the shadow's centre comes from
};
AnalyticGeometry analytic_geometry(const Shot& shot, double frame);

// The terminator's strips: the receiver's height over z = 0 and its normal at a place along the geometry's
// normal.
struct TerminatorStrip {
    double height = 0, slope = 0;
    glm::dvec3 normal{0, 0, 1};
};
TerminatorStrip terminator_strip(const Shot& shot, double along);
double terminator_strip_width(const Shot& shot);

// The shot's caster moves like any object: fills shot.objects. Call once, when the shot is otherwise
// complete.
void add_analytic_motion(Shot& shot);

Model analytic_model(const Shot& shot);
Camera analytic_camera(const Shot& shot);

// Exact visibility at every pixel's centre, rows from the top.
std::vector<double> analytic_image(const Shot& shot, double frame);

// 1 where the camera sees the receiver: all of the image but what a sphere at rest covers right at its
// contact.
std::vector<uint8_t> analytic_receivers(const Shot& shot, double frame);

// Where an object touches the receiver, in pixels; absent where none does.
std::optional<ContactLine> analytic_contact(const Shot& shot, double frame);

// Why no such scene exists under this sun at this frame; nothing where it does.
struct AnalyticProblem {
    const char* key;  // of the shot, whose value is to blame
    std::string text;
};
std::optional<AnalyticProblem> analytic_problem(const Shot& shot, double frame);

// Lengths that the model and the closed forms share, in metres.
double analytic_half_diagonal(const Shot& shot);
// No ray from the visible receiver to the sun passes the caster's height further from its centre than this.
double analytic_reach(const Shot& shot);
struct SlatRange {
    int first = 0, last = 0;
};
SlatRange fence_slats(const Shot& shot);

}  // namespace penumbra
