// SPDX-License-Identifier: MIT
// What a plan's `validate` passes have found, frame by frame: texels that are not finite or out of range, and
// in which frame each resource had the first of them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/validate.h"
#include "penumbra/view.h"

namespace penumbra {

// Texels by the worst of their channels.
struct TexelCounts {
    uint64_t checked = 0, nan = 0, inf = 0, out_of_range = 0;
    uint64_t bad() const { return nan + inf + out_of_range; }
};

struct Finding {
    ValidatePass pass;
    TexelCounts all;  // over all frames
    std::optional<uint32_t> first_frame;
    TexelCounts first;  // in that frame
};

// One finding per validate pass, in the plan's order.
std::vector<Finding> no_findings(const Plan& plan);
void add_frame(std::vector<Finding>& findings, uint32_t frame, const std::vector<PassStatistics>& passes);

// A line per resource that is not clean, the earliest first: within a frame that is the dataflow's order, so
// the first line names the culprit. Empty: all is clean.
std::string complaint(const std::vector<Finding>& findings);

// {resource: {checked, nan, inf, out_of_range, first_frame}}; null for what the plan's nodes write and nobody
// looked at. Null as a whole where no pass validates.
nlohmann::ordered_json findings_json(const Plan& plan, const std::vector<Finding>& findings);

}  // namespace penumbra
