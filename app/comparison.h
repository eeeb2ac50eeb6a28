// SPDX-License-Identifier: MIT
// Folders of rendered visibility against a folder of references: which files are read for which metric
// (host/metrics/metrics.h), and the sums over frames. What the folders do not have the files for stays
// absent.
#pragma once

#include "app/commands.h"
#include "app/mask_folder.h"
#include "host/metrics/metrics.h"

namespace penumbra {

struct Comparison {
    std::vector<uint32_t> frames;
    size_t seeds = 0;
    ReferenceInfo truth;
    MaskMetrics mask;
    std::optional<double> bias_max_9x9, ssim;
    std::optional<FlipPool> flip;  // of the first seed
    std::optional<double> relmse;  // both: of the lit picture; albedo, normal and sun are the reference's
    std::optional<double> peter_panning_px;  // where the scene has a known contact
    DecisionMetrics decisions;               // from captures of undecided_words and preloaded_hits
    std::optional<double> interval;          // from those of undecided_words and hits, beside whole rays'
    std::optional<double> flicker_rms, flicker_p99;  // from consecutive frames
    std::optional<double> lag_px;                    // where the truth moves
    StepResponse step;                               // where it changes suddenly
};

std::optional<Comparison> compare_folders(const CompareArguments& arguments, Diagnostics& diagnostics);

}  // namespace penumbra
