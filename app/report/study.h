// SPDX-License-Identifier: MIT
// What a report measures, and how much of it: every figure of the page follows from these numbers.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace penumbra::report {

struct Study {
    std::array<uint32_t, 2> size{384, 216};
    std::string light;     // the lamp that the masks are of, by its name in the shots; empty: the sun
    uint32_t seeds = 3;    // every run is repeated with seeds 1 to n
    uint32_t rounds = 3;   // every pass is timed so often in every frame that counts: the least time counts
    uint32_t rays = 1024;  // per pixel of a penumbra, of the reference
    // Static: frames since a cut, from 1, at which the error is taken. They hold 1, 8 and 64, the headline's;
    // or are none, and nothing is measured standing still.
    std::vector<uint32_t> after_cut{1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64};
    // The shot as it is: its first frames, of which every nth is judged; the first `settling` ones are left
    // out of pooled errors, and costs are of the same frames as these.
    uint32_t moving_frames = 64, moving_every = 4, settling = 8;
    uint32_t motion_frames = 24;  // so many last ones of these are shown as a picture that moves; 0: none
    // A straight edge that moves: all speeds (pixels per frame across the edge, positive where the shadow
    // grows), at the frame at which the penumbra's middle passes the image's. No widths: no edges.
    std::array<uint32_t, 2> edge_size{192, 96};
    uint32_t edge_frame = 63;
    std::vector<double> edge_widths_px{8, 16, 32};
    std::vector<double> edge_speeds_px{-4, -2, -1, -0.5, -0.25, -0.1, 0, 0.1, 0.25, 0.5, 1, 2, 4};
    // Along the border of analytic scenes: what a denoiser does at the image's border is not in question
    // there.
    uint32_t analytic_border_px = 24;
};

// For a first look, in minutes on two cores.
inline Study quick_study() {
    Study study;
    study.size = {192, 108};
    study.seeds = study.rounds = 2;
    study.rays = 256;
    study.moving_frames = 40;
    study.moving_every = 8;
    study.motion_frames = 16;
    study.edge_size = {160, 96};
    study.edge_frame = 31;
    study.edge_widths_px = {16};
    study.edge_speeds_px = {-4, -1, -0.25, 0, 0.25, 1, 4};
    return study;
}

// Speed against error alone, at sizes that people look at: frame 15 of each shot as it moves.
inline Study front_study() {
    Study study;
    study.size = {640, 360};
    study.seeds = 1;
    study.moving_frames = study.moving_every = 16;
    study.motion_frames = 0;
    study.after_cut.clear();
    study.edge_widths_px.clear();
    study.edge_speeds_px.clear();
    return study;
}

// Plain rays, per pixel, rising: what every contender has to beat. With one ray there is nothing that proofs
// before it could spare.
inline constexpr std::array<uint32_t, 7> brute_force_rays{1, 2, 4, 8, 16, 32, 64};
inline constexpr std::array<uint32_t, 6> proved_rays{2, 4, 8, 16, 32, 64};

}  // namespace penumbra::report
