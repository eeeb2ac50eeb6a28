// SPDX-License-Identifier: MIT
// What the node `beams` decides of whole tiles, and on the processor, in double precision, what it saw: for
// figures and tests. docs/method.md.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/session.h"
#include "host/scene/scene_alpha.h"

namespace penumbra {

enum class TileVerdict { lit, dark, open };

// Everything is seen along the beam: x to the right, y up, and 1 from the middle is the beam's rim, wherever
// along it.
struct BeamTriangle {
    uint32_t index = 0;               // of Scene::triangles()
    std::vector<glm::dvec2> outline;  // as far as tile_beam_reach
    bool in_patch = false;
};

struct BeamEdge {
    glm::dvec2 from, to;
};

struct TileBeam {
    std::array<uint32_t, 2> tile{};
    TileVerdict verdict = TileVerdict::open;  // the node's
    uint32_t pixels = 0;                      // of the tile, whose rays it decides
    // What is ahead of some ray's start. Where the verdict is `dark` and a patch was found that closes the
    // beam off, its triangles are marked.
    std::vector<BeamTriangle> triangles;
    std::vector<BeamEdge> borders;  // across which no triangle goes on, or one that folds back
    bool closed = false;            // there is such a patch

    double nearest() const;         // of all triangles, from the middle; infinite where there are none
    double nearest_border() const;  // likewise
    size_t patch() const;           // triangles
};

// How far from its middle a beam's surroundings are listed, in radii.
inline constexpr double tile_beam_reach = 1.7;

// A frame that a session of many_rays.json has run after a reset and captured captures() of.
class TileBeams {
  public:
    TileBeams(const Session& session, uint32_t frame);

    static const std::vector<std::string>& captures();
    static const std::vector<std::string>& settings();  // of the pipeline

    std::array<uint32_t, 2> tiles() const { return tiles_; }
    std::optional<TileVerdict> verdict(std::array<uint32_t, 2> tile) const;  // none where nobody asked
    // Of a tile that has a verdict.
    TileBeam beam(std::array<uint32_t, 2> tile) const;

  private:
    struct Cone;
    uint32_t word(std::array<uint32_t, 2> tile) const { return tile[1] * tiles_[0] + tile[0]; }
    Cone cone(std::array<uint32_t, 2> tile) const;
    std::vector<uint32_t> others(uint32_t corner) const;
    bool goes_on(uint32_t corner, uint32_t other, const Cone& cone) const;
    std::vector<uint32_t> patch_from(uint32_t first, const Cone& cone) const;

    std::array<uint32_t, 2> tiles_;
    std::vector<uint32_t> asked_, hits_, open_;  // bits of a tile's pixels
    std::vector<glm::dvec3> starts_;             // of each pixel's rays
    std::array<uint32_t, 2> size_;
    glm::dvec3 to_sun_;
    double tangent_;  // of the sun's angular radius
    std::vector<Triangle> triangles_;
    std::vector<glm::dvec4> spheres_;  // around each: centre, radius
    std::optional<SceneAlpha> alpha_;
    struct Edge {
        uint64_t ends;    // numbers of its positions, the lesser one first
        uint32_t corner;  // triangle * 3 + the one opposite
        auto operator<=>(const Edge&) const = default;
    };
    std::vector<uint32_t> numbers_;  // of each corner's position
    std::vector<Edge> edges_;        // sorted
};

}  // namespace penumbra
