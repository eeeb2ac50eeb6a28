// SPDX-License-Identifier: MIT
// Hard cases 41 and 42 in the long run: a pipeline on a straight penumbra that nothing changes, for as many
// frames as one likes, judged by the closed form in windows of 256 frames; then the caster jumps, and a
// history that had stalled would hold what it has.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/device/device.h"

namespace penumbra::test {

struct SoakOptions {
    std::string pipeline = "shadows_fast";
    uint32_t frames = 2000;
    std::array<uint32_t, 2> size{64, 48};
    double width_px = 12;  // of the penumbra
};

struct SoakWindow {
    uint32_t first = 0;  // of 256 frames
    double n_eff = 0;    // effective samples of a frame, by the mean of their squared errors
    double mean = 0;     // visibility of all pixels and frames
    long resident_kib = 0, open_files = 0;  // of the process, at its end
};

struct Soak {
    std::vector<SoakWindow> windows;  // the first starts at frame 192, the last ends with the run
    size_t nonfinite = 0;             // texels of all windows

    // Share of the change that is still to come in the third frame after a jump by a third of the image's
    // width: of the whole run, and of one that began 256 frames before the jump.
    double left = 0, left_of_young = 0;

    // The last third of the windows against the first third: one window's own noise is of the size of the
    // limits.
    double drift() const;       // of the mean
    double n_eff_kept() const;  // quotient
    double kept_noise() const;  // its deviation, by what neighbouring windows differ

    // Since the end of the first window.
    long grown_kib() const;
    long more_files() const;
};

Soak soak(Device& device, const SoakOptions& options);

// The limits: the mean drifts by no more than 1e-4, .95 of N_eff are kept, less two deviations of the
// windows' noise, the jump is followed as a young history follows it, everything is finite, and the process
// has neither 8 MiB nor an open file more than at the end of the first window.
bool soak_holds(const Soak& result);

}  // namespace penumbra::test
