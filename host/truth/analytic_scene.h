// SPDX-License-Identifier: MIT
// What a shot says of an analytic scene (host/truth/analytic.h): lengths in pixels of the image.
#pragma once

#include <glm/vec2.hpp>
#include <variant>
#include <vector>

namespace penumbra {

// Sheets that hang over the receiver. The edge of the half-plane, and the lines of the others, stand across
// the direction in which the scene moves.
struct HalfPlane {
    double tilt_deg = 0;  // of the receiver's far side away from the camera, 0 to 85; lengths in pixels and
                          // the edge's angle stay what the image shows
};
struct Slit {
    double width_px = 0;  // of the opening between two half-planes
};
struct Fence {
    double period_px = 0;
    double duty = 0;  // opaque share of a period
};
struct Polygon {
    std::vector<glm::dvec2> points;  // about the shadow's centre, y down; no edge crosses another
};
struct Sphere {
    double radius_px = 0;
};

// Objects that stand on the receiver: their shadows begin where they touch it.
struct ContactPoint {
    double radius_px = 0;  // of a sphere at rest
};
struct ContactWall {
    double height = 0;  // metres; upright and thin
};

// A receiver that bends away from the sun, in flat strips: nothing else casts a shadow.
struct Terminator {};

using AnalyticShape =
    std::variant<HalfPlane, Slit, Fence, Polygon, Sphere, ContactPoint, ContactWall, Terminator>;

struct AnalyticScene {
    double penumbra_px = 0;  // at the first frame's sun, across a straight edge; what hangs, hangs so high.
                             // The terminator: from fully lit to fully dark
    double edge_deg = 0;     // 0: the edge is upright in the image and light is on the right; turns clockwise
    double speed_px = 0;     // per frame across the edge; positive: the shadow grows
    double offset_px = 0;  // at frame 0, of the penumbra's middle, the shadow's centre, or the line or point
                           // of contact from the image's centre, towards the light
    AnalyticShape shape = HalfPlane{};
};

}  // namespace penumbra
