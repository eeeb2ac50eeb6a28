// SPDX-License-Identifier: MIT
// Speed against error of one shot as it moves: where a contender stands beside plain rays that take the same
// time, or have the same error. Made of the rows' medians and nothing else.
#pragma once

#include <optional>
#include <string>

#include "app/report/results.h"
#include "host/metrics/front.h"

namespace penumbra::report {

// Whether costs are CPU milliseconds.
bool cost_is_cpu(const Results& results);

// Cost of the mask and N_eff; nothing where a row was not timed, or there is no penumbra. An error that
// cannot be told from the truth's own is none: infinitely good.
std::optional<FrontPoint> front_point(const Results& results, const Row& row);

struct FrontFigure {
    bool exact = false;     // no error beyond the truth's own
    bool on_front = false;  // no other contender is as fast and as good, and faster or better
    // Its N_eff over that of the best plain rays, behind proofs or not, in the time that it takes.
    std::optional<Front::Reading> over_plain;
    // The time in which brute force has its N_eff, over its own.
    std::optional<Front::Reading> brute_force_time;
};

FrontFigure front_figure(const Results& results, const Row& row);

// As tables have them: "12", "~180" where it is extrapolated, "exact", a dash for nothing.
std::string over_plain_text(const FrontFigure& figure);
std::string brute_force_time_text(const FrontFigure& figure);

}  // namespace penumbra::report
