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
    // Called with the work that has been done since it was called last, for a progress bar.
    std::function<void(uint64_t)> step;
    std::function<void(const std::string&)> say;  // a line for whoever waits
};

// Adds the shot and its rows. False, with diagnostics, where the shot or a plan is wrong.
bool measure_shot(const Bench& bench, const ReportShot& shot, Results& results, Diagnostics& diagnostics,
                  std::vector<std::string>& warnings);

// Adds one point per contender. Contenders whose masks were the same to the bit in all shots that the results
// hold are run once.
bool measure_edge(const Bench& bench, const EdgeShot& edge, Results& results, Diagnostics& diagnostics,
                  std::vector<std::string>& warnings);

// All that `step` will have been told of, in pixels of one run of all contenders.
uint64_t work_of_shot(const Study& study);
uint64_t work_of_edge(const Study& study);

}  // namespace penumbra::report
