// SPDX-License-Identifier: MIT
// What a pixel's neighbours' rays say of its sun, on the processor: the idea of the node `gather` without its
// windows, weights and regression, for figures. docs/method.md.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "app/session.h"
#include "host/truth/coverage.h"

namespace penumbra {

// One pixel's ray, as another pixel sees it.
struct GatheredRay {
    std::array<int, 2> offset{};  // of its pixel
    bool lit = false;
    bool on_surface = false;       // its pixel lies on the asking pixel's plane
    std::array<double, 2> own{};   // the point of the sun that it went to, on a disc of radius 1
    std::array<double, 2> seen{};  // which point of the asking pixel's sun it is a test of
    bool counts() const { return on_surface && seen[0] * seen[0] + seen[1] * seen[1] < 1; }
};

struct Gathered {
    std::vector<GatheredRay> rays;  // row by row, of (2 reach + 1)^2 pixels
    double distance_m = 0;          // of the blockers
    size_t counted() const;
    double visibility() const;  // share of the rays that count and are lit; 1 where none counts
    double unsheared() const;   // of all rays on the surface, wherever they went
};

// A frame that a session of one_ray.json has run and captured captures() of.
class RayGatherer {
  public:
    RayGatherer(const Session& session, uint32_t frame);

    static constexpr int reach = 5;  // pixels to each side
    static const std::vector<std::string>& captures();

    std::array<uint32_t, 2> size() const { return size_; }
    bool shows_surface(std::array<uint32_t, 2> pixel) const { return depth_[index(pixel)] > 0; }
    // Nothing where the pixel shows no surface or no ray around it has met anything.
    std::optional<Gathered> gather(std::array<uint32_t, 2> pixel) const;

  private:
    size_t index(std::array<uint32_t, 2> pixel) const { return size_t{pixel[1]} * size_[0] + pixel[0]; }
    double blockers_m(std::array<uint32_t, 2> pixel) const;

    std::array<uint32_t, 2> size_;
    glm::dmat3 axes_;
    double tangent_;  // of the sun's angular radius
    std::vector<float> depth_;
    std::vector<glm::dvec3> place_, normal_;  // of each pixel's surface
    std::vector<uint32_t> hits_, points_, blockers_;
};

}  // namespace penumbra
