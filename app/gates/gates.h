// SPDX-License-Identifier: MIT
// How well a pipeline's visibility keeps to straight penumbrae whose truth is a closed form: standing still,
// moving at many speeds, after a jump of the sun, and on receivers that are seen at grazing angles. Every
// figure is a median over seeds with its 95 % interval (app/report/statistics.h).
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "app/report/statistics.h"
#include "app/session.h"

namespace penumbra::gates {

using report::Estimate;

struct Study {
    std::array<uint32_t, 2> size{192, 112};
    uint32_t border_px = 24;  // what a denoiser does along the image's border is not in question
    uint32_t seeds = 16;
    std::vector<double> widths_px{8, 16, 32};
    double edge_deg = 20;
    uint32_t still_frames = 64, flicker_from = 32;  // steps between frames are judged from then on
    std::vector<double> speeds_px{-4, -2, -1, -0.5, -0.25, -0.1, 0.1, 0.25, 0.5, 1, 2, 4};
    uint32_t moving_frame = 39;
    uint32_t jump_frame = 32, frames_after_jump = 12;
    double jump_px = 40;  // of the shadow, either way: farther than any window of ours reaches
    std::vector<double> tilts_deg{60, 75, 85}, tilted_edges_deg{0, 17, 45, 90, 135}, tilted_widths_px{8, 32};
    uint32_t tilted_seeds = 4;  // of each of the edges
};

struct Bench {
    Device& device;
    const NodeSet& nodes;
    const CheckedPipeline& pipeline;
    const Study& study;
    std::function<void()> step;  // one seed of one shot is done
    Diagnostics& diagnostics;
    std::vector<std::string>& warnings;
};

// Whether any pixel that counts has its centre in the penumbra of an edge that stands still. A narrow one
// along the rows or columns of pixels may lie between them, and then there is nothing to judge.
bool has_penumbra(const Study& study, double width_px);
// Whether any such pixel changes by more than a half when the sun jumps, either way: a wide one changes
// little.
bool has_jump(const Study& study, double width_px);

// Each is absent after an error, which is a diagnostic.

struct Still {
    Estimate first, last;  // effective samples per pixel of the first frame and of the last
    // rms of what changes from frame to frame, in 1/255: over the penumbra's pixels, over all that count.
    Estimate flicker, flicker_all;
};
std::optional<Still> measure_still(const Bench& bench, double width_px);

struct Moving {
    double speed_px = 0;
    Estimate n_eff;
};
std::optional<std::vector<Moving>> measure_moving(const Bench& bench, double width_px);

struct Jump {
    Estimate k90;    // host/metrics/lag.h; a change that never settles counts as all frames looked at
    Estimate n_eff;  // effective samples per pixel, one frame after the jump's
    std::vector<double> left;  // share of the change, from the jump's frame on; medians
};
// The sun jumps so that the shadow moves by `distance_px`, positive: it grows. `told`: the pipeline knows
// that suns can move; untold, it is to find out, as of a caster that jumps.
std::optional<Jump> measure_jump(const Bench& bench, double width_px, double distance_px, bool told);

struct Tilted {
    double mean = 0, worst = 0, worst_edge_deg = 0;  // over edges, of the medians
};
std::optional<Tilted> measure_tilted(const Bench& bench, double width_px, double tilt_deg);

}  // namespace penumbra::gates
