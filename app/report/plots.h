// SPDX-License-Identifier: MIT
// The report's plots, as inline SVG. Colours are the page's: each contender has a class.
#pragma once

#include <string>

#include "app/report/results.h"

namespace penumbra::report {

// Class of a contender's colour: "p0", "p1", ... for pipelines, "pb" for brute force, "pm" for many_rays.
std::string accent(const Results& results, size_t contender);
// How the page names a contender.
std::string label(const Contender& contender);

// The title of an axis of costs.
std::string cost_title(const Results& results);

enum class Quality { rmse, n_eff };
// Cost of the mask against its quality in the moving shot; a circle per row. Plain rays are lines, and so is
// the front of all.
std::string pareto_plot(const Results& results, size_t shot, Quality quality);

// Error over all receivers against frames since a cut, in a scene that stands still.
std::string after_cut_plot(const Results& results, size_t shot);
// The same against frames of the moving shot.
std::string over_time_plot(const Results& results, size_t shot);

// Time per pass, a bar per pipeline; brute force, which is one pass over and over, is left out.
std::string passes_plot(const Results& results, size_t shot);

// N_eff against the speed of a straight edge.
std::string edge_plot(const Results& results, double width_px);

}  // namespace penumbra::report
