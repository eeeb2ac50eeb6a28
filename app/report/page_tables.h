// SPDX-License-Identifier: MIT
// The report's tables, and the commands that repeat a row.
#pragma once

#include <string>

#include "app/report/results.h"
#include "penumbra/plan.h"

namespace penumbra::report {

// Four numbers per shot and contender: N_eff 1, 8 and 64 frames after a cut, and, where edges were measured,
// the worst one's.
std::string headline_table(const Results& results);
// Cost and quality of all contenders on a shot, moving.
std::string shot_table(const Results& results, size_t shot);
// The worst speed per width, and the lag there.
std::string edge_table(const Results& results);
// Groups, reads and writes per pass.
std::string passes_table(const Plan& plan);

// Commands for the moving shot's figures of a row, the after-cut ones and an edge's.
std::string commands(const Results& results);

// The width whose worst edge the headline shows.
double headline_width_px(const Results& results);

}  // namespace penumbra::report
