// SPDX-License-Identifier: MIT
// Flicker: how much a surface's visibility changes from frame to frame beyond what the truth changes. The
// previous frame is brought along by the true motion, the same for image and truth, so that neither the
// camera nor a moving shadow counts.
#pragma once

#include <optional>

#include "host/metrics/compared_frame.h"

namespace penumbra {

// Two consecutive frames. Motion and depth are the G-buffer's (docs of host inputs): previous uv = uv +
// motion, depths in metres along the view axis.
struct TimeStep {
    const ComparedFrame& now;
    const ComparedFrame& before;  // of the same size and as many seeds
    std::span<const float> motion_x, motion_y, depth_change;
    std::span<const float> depth, depth_before;
};

struct FlickerSums {
    double squares = 0;
    uint64_t pixels = 0;  // pixel, seed and step triples
    std::vector<double> pixel_squares;
    std::vector<uint32_t> pixel_steps;

    std::optional<double> rms() const;
    // 99th percentile over the pixels of each pixel's own rms in time.
    std::optional<double> p99() const;
};

void add_flicker(const TimeStep& step, FlickerSums& sums);

}  // namespace penumbra
