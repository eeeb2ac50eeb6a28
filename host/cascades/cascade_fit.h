// SPDX-License-Identifier: MIT
// Where the sun's shadow maps lie: pure functions in double precision. The view is cut into slices; a slice's
// map is a square about its bounding sphere, whose size does not change as the camera turns, and whose corner
// steps by whole texels, so that a texel always covers the same piece of the world ("stable" cascades). Where
// one map of the whole scene has texels as fine as the nearest slice's would be, there is that one alone.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>

#include "penumbra/frame_block.h"
#include "shaders/common/blocks.h"

namespace penumbra {

inline constexpr uint32_t max_cascades = 4;

// Right-handed: u, v across the light, `away` along it.
struct LightFrame {
    glm::dvec3 u{1, 0, 0}, v{0, 1, 0}, away{0, 0, -1};

    glm::dvec3 of(const glm::dvec3& world) const {
        return {glm::dot(u, world), glm::dot(v, world), glm::dot(away, world)};
    }
};

// Without a branch on the direction's length or a choice of "up": finite and orthonormal for every unit
// vector (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
LightFrame light_frame(const glm::dvec3& to_sun);

struct CascadeArea {
    glm::dvec2 corner{0};  // least u and v, metres in the light's frame, a multiple of texel_m
    double texel_m = 0;

    friend bool operator==(const CascadeArea&, const CascadeArea&) = default;
};

struct CascadeFit {
    LightFrame light;
    uint32_t size = 0;   // texels along a side
    uint32_t count = 0;  // 0: there is nothing to map
    std::array<CascadeArea, max_cascades> areas{};
    double near_m = 0;   // of depth 0 along `away`: nothing of the scene is nearer to the sun
    double depth_m = 0;  // from there to depth 1: nothing of the scene is farther
};

struct CascadeRequest {
    Camera camera;  // positions as `low` and `high`
    bool orthographic = false;
    glm::dvec3 to_sun{0, 1, 0};
    double angular_radius = 0;
    glm::dvec3 low{0}, high{0};  // box of all triangles
    uint32_t size = 1024;
};

// No input makes it produce anything but finite areas of positive size, or none.
CascadeFit fit_cascades(const CascadeRequest& request);

// Metres about `origin`, world axes -> u and v in texels of an area, and metres from depth 0.
glm::dmat4x3 texels_from_metres(const CascadeFit& fit, uint32_t cascade, const glm::dvec3& origin);

// The block that shaders read. `camera`: in the frame of the fit.
blocks::Cascades cascade_block(const CascadeFit& fit, const glm::dvec3& camera);

}  // namespace penumbra
