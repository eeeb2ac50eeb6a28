// SPDX-License-Identifier: MIT
// report.json of `render`: what ran, on what, what it cost and what it wrote. Unknown values are null, never
// absent.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/commands.h"
#include "app/outputs.h"
#include "app/session.h"
#include "app/validation.h"

namespace penumbra {

// Costs of all executed frames; the first two are left out of medians where there are more.
nlohmann::ordered_json render_report(const RenderArguments& arguments, const Session& session,
                                     const DeviceInfo& device, std::array<uint32_t, 2> frames,
                                     const std::vector<FrameCost>& costs,
                                     const std::vector<Finding>& findings, const OutputWriter& outputs,
                                     const std::vector<std::string>& warnings);

// The same for people: milliseconds per pass, and the heap beside its bounds.
void print_summary(const nlohmann::ordered_json& report);

}  // namespace penumbra
