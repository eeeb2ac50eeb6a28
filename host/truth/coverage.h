// SPDX-License-Identifier: MIT
// The node `cover` on the processor, a pixel at a time and in double precision: the same samples, tables,
// turn and dither, so that a figure or a test can say of one pixel which triangle hides which samples. Areas
// are exact here and within 2.2e-4 in the shader (shaders/visibility/light_mask.glsl), so that now and then a
// line cuts off one sample more or less. docs/coverage.md.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "host/bvh/bvh.h"
#include "host/scene/scene.h"
#include "host/scene/scene_alpha.h"
#include "host/standalone.h"
#include "nodes/tables/light_samples.h"

namespace penumbra {

using SampleMask = std::bitset<256>;

// sun_frame() of sun_sample.glsl: two axes across the light, and the unit vector `to_sun` itself.
glm::dmat3 sun_frame(const glm::dvec3& to_sun);

// What a pixel's coverage is asked from: a point off its surface, in the tree's frame, and the sun.
struct CoverageReceiver {
    glm::dvec3 start{0}, normal{0, 1, 0};
    glm::dvec3 start_of_beam{0};  // farther along the way to the sun (beams.comp)
    glm::dmat3 axes{1};  // columns: two across the sun, turned by the pixel's noise, and the one towards it
    double dither = 0;   // 0 to 1: rounds a share of the samples up or down
    double angular_radius = 0;  // radians
    // Of what is looked through (looked_through.glsl): the way to the viewer, how far the start may lie past
    // the end of what it is on, half a step of the rasteriser's grid there, and how deep inside an outline
    // that may have moved, metres.
    glm::dvec3 to_viewer{0, 0, 1};
    double beyond_edge_m = 0, grid_m = 0, most_inside_m = 0;
};

struct CoveragePixel {
    std::array<uint32_t, 2> at{};
    float view_depth = 0;           // metres; 0: no surface
    std::array<float, 2> normal{};  // octahedral, as the node guides writes receiver_normal
};

// How far off its surface what starts at a pixel does, metres (robust_offset_m() of ray_offset.glsl, of a
// depth that is of the pixel's centre).
double start_offset_m(const StandaloneFrame& frame, const CoveragePixel& pixel);

// `blue_noise`: the 128 x 128 words of the node's table.
CoverageReceiver coverage_receiver(const StandaloneFrame& frame, uint32_t seed,
                                   std::span<const uint32_t> blue_noise, const CoveragePixel& pixel);

// A sun's samples and the table of half-planes across it.
class SampledSun {
  public:
    // One of light_sample_counts; annealing them takes up to two seconds.
    explicit SampledSun(uint32_t count);

    uint32_t count() const { return static_cast<uint32_t>(samples_.size()); }
    // Where a sample of a sun of this angular radius lies, in units of the tangent of that.
    std::array<double, 2> place(uint32_t sample, double angular_radius) const;
    // The samples at which line . (x, y, 1) >= 0, x and y in tangents of angles from the sun's middle.
    SampleMask positive_side(const glm::dvec3& line, double angular_radius, double dither) const;

  private:
    std::vector<LightSample> samples_;
    std::vector<uint32_t> half_planes_;
};

struct SeenTriangle {
    uint32_t index = 0;               // of Scene::triangles()
    std::array<glm::dvec3, 3> lines;  // it stands before the points with line . (x, y, 1) >= 0 for all three
    bool alpha = false;               // has holes
    SampleMask hidden;                // by it alone
};

struct PixelCoverage {
    glm::dvec3 surface_line{0};  // the receiver's own plane hides what is on its negative side
    SampleMask by_surface, hidden;
    std::vector<SeenTriangle> triangles;  // in or near the sun's cone
    uint32_t samples = 0;

    uint32_t hiding() const;  // how many triangles hide a sample
    double visibility() const { return 1 - double(hidden.count()) / samples; }
};

// A scene's triangles at one moment.
class CoverageScene {
  public:
    CoverageScene(const Scene& scene, double frame);

    // Triangles up to `reach` radii from the sun's middle are listed, whether they hide anything or not.
    PixelCoverage cover(const SampledSun& sun, const CoverageReceiver& receiver, double reach = 1) const;

  private:
    // By corner, the edge opposite to it: its line, positive on the triangle's side, and the samples there.
    struct Sides {
        std::array<glm::dvec3, 3> lines;
        std::array<SampleMask, 3> masks;
    };
    std::optional<Sides> see(const SampledSun& sun, const CoverageReceiver& receiver, uint32_t index) const;
    static bool is_convex(const Sides& first, size_t opposite, const glm::dvec3& other);
    SeenTriangle hidden_by(const SampledSun& sun, const CoverageReceiver& receiver, uint32_t index,
                           const Sides& sides, const SampleMask& within) const;
    void add_leaf(const SampledSun& sun, const CoverageReceiver& receiver, double reach,
                  const std::array<uint32_t, 4>& corners, PixelCoverage& out) const;

    std::vector<Triangle> triangles_;
    Bvh bvh_;
    std::optional<SceneAlpha> alpha_;
};

}  // namespace penumbra
