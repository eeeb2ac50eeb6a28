// SPDX-License-Identifier: MIT
// What of a light that is near a blocker leaves open, in closed form and by many rays. Of a disc and a
// rectangle the share of the area, of a sphere the share of the cap that a receiver sees, of a tube the share
// of the rectangle through its axis that faces the receiver. Double precision; positions in metres relative
// to one and the same point.
#pragma once

#include <array>
#include <functional>
#include <glm/glm.hpp>
#include <span>

#include "shaders/common/blocks.h"

namespace penumbra {

// A light as a receiver sees it, made from its block.
class NearLight {
  public:
    explicit NearLight(const blocks::Light& block);

    // As the shaders decide it (shaders/common/light.glsl).
    bool reaches(const glm::dvec3& receiver) const;

    // The point of the light for two numbers of the unit square, areas kept, and the end of a ray from
    // `receiver` to it.
    glm::dvec3 target(const glm::dvec3& receiver, const glm::dvec2& u) const;

    // The open share behind a convex polygon between the receiver and the light, which faces either way.
    double visibility(const glm::dvec3& receiver, std::span<const glm::dvec3> polygon) const;

    const glm::dvec3& centre() const { return centre_; }

  private:
    glm::dvec3 across(const glm::dvec3& receiver) const;

    uint32_t kind_;
    glm::dvec3 centre_, u_, v_, facing_;
    double range_, cos_outer_;
    bool on_;
};

// The share of the unit disc that a polygon covers, in either winding.
double disc_share(std::span<const glm::dvec2> polygon);
// The share of the square [-1, 1]^2 that a convex polygon covers.
double square_share(std::span<const glm::dvec2> polygon);

}  // namespace penumbra
