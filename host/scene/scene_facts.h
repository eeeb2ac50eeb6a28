// SPDX-License-Identifier: MIT
// What makes a shot hard, as numbers: how much of the picture lies in penumbra, how many casters are narrower
// than a shadow map's texel, how much of a frame has no history. Measured on the scene itself, by no
// pipeline.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/bvh/bvh.h"
#include "host/device/device.h"
#include "host/standalone.h"

namespace penumbra {

// A caster is a connected piece of the mesh of one object: triangles that share corner positions. Those that
// no ray can meet, as translucent ones in Scene::triangles(), belong to none.
struct CasterWidths {
    std::vector<double> width_m;  // per caster: its narrow extent, seen from the sun
};
CasterWidths caster_widths(const std::vector<Triangle>& triangles, const std::vector<uint32_t>& objects,
                           const glm::dvec3& to_sun);

struct SceneFacts {
    size_t triangles = 0;  // without translucent ones
    size_t casters = 0, sub_texel = 0;
    double texel_m = 0;      // of one map of 2048 x 2048 texels over the scene's box: its diagonal / 2048
    double penumbra = 0;     // of the receivers: some, but not all, of `rays` are blocked
    double receivers = 0;    // of the pixels
    double disoccluded = 0;  // of the receivers, whose point the previous frame did not see; mean over frames
    uint32_t rays = 0, frames = 0;
};

// Frames 1, 22, 43, .. of the shot. The G-buffer comes from the device, the rays from the CPU's traversal.
SceneFacts scene_facts(Device& device, StandaloneHost& host);

}  // namespace penumbra
