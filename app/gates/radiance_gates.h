// SPDX-License-Identifier: MIT
// How well a pipeline's radiance keeps to what it must be: a white furnace, a room that stands still and one
// that moves against their converged truth, a lamp that goes off. Figures are by class of roughness
// (host/metrics/radiance_error.h).
#pragma once

#include <functional>

#include "app/commands.h"
#include "app/gates/radiance_room.h"
#include "app/session.h"
#include "host/metrics/radiance_error.h"

namespace penumbra::gates {

struct RadianceStudy {
    std::array<uint32_t, 2> size{128, 72};
    uint32_t seeds = 4, rays = 1024;  // of the truth
    uint32_t furnace_frames = 9;
    std::vector<uint32_t> after{1, 9, 65};  // frames that have been run, standing still
    uint32_t moving_frames = 17;            // whose last is judged
    std::vector<uint32_t> after_off{4, 8, 12, 16, 24};
};

struct RadianceBench {
    Device& device;
    const NodeSet& nodes;
    const CheckedPipeline& pipeline;
    const std::string signal;  // which it puts out: specular or diffuse
    const RadianceStudy& study;
    const RadianceScenes& scenes;
    Diagnostics& diagnostics;
    std::vector<std::string>& warnings;
    std::function<void(const std::string& what, double share)> told;  // what is being done; may be empty
};

// Each is absent after an error, which is a diagnostic.

// The largest distance from 1 of any pixel of a class, in any frame and under any seed.
std::optional<std::array<double, roughness_classes>> measure_furnace(const RadianceBench& bench);
// After each of study.after; the last one's sums have what flickers.
std::optional<std::vector<RadianceErrorSums>> measure_still(const RadianceBench& bench);
std::optional<RadianceErrorSums> measure_moving(const RadianceBench& bench);
// Of the light of the lamp, the share that is left after each of study.after_off frames without it: of the
// mean over all surfaces, less what is there after 63.
std::optional<std::vector<double>> measure_lamp_off(const RadianceBench& bench);

}  // namespace penumbra::gates

namespace penumbra {

// penumbra gates --signal specular or diffuse. Returns an exit code.
int run_radiance_gates(const GatesArguments& arguments);

}  // namespace penumbra
