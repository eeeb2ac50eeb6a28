// SPDX-License-Identifier: MIT
// Runs all contenders on all shots and judges their masks. All stand ready at once and take turns frame by
// frame, in an order that rotates, so that a disturbance of the machine meets all of them.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "app/report/results.h"
#include "app/report/shots.h"

namespace penumbra::report {

// What to measure with; `results` has the study, the device and the contenders already.
struct Bench {
    Device& device;
    const NodeSet& nodes;
    std::filesystem::path folder;  // of the report: images go to its images/
    std::function<void()> step;    // called after every unit of work, for a progress bar
};

// Adds the shot and its rows. False, with diagnostics, where the shot or a plan is wrong.
bool measure_shot(const Bench& bench, const ReportShot& shot, Results& results, Diagnostics& diagnostics,
                  std::vector<std::string>& warnings);

// Adds one point per contender.
bool measure_edge(const Bench& bench, const EdgeShot& edge, Results& results, Diagnostics& diagnostics,
                  std::vector<std::string>& warnings);

// How often `step` will be called for so many shots and edges.
uint32_t steps_of(const Study& study, size_t shots, size_t edges);

}  // namespace penumbra::report
