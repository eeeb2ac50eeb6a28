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

// The frames that were asked for, and what all that were executed cost, from `start` on.
struct RenderedFrames {
    std::array<uint32_t, 2> wanted{};
    uint32_t start = 0;
    std::vector<FrameCost> costs;
};

// The first two frames are left out of medians where there are more. `shot_file`: as seen from the folder
// that the report goes to.
nlohmann::ordered_json render_report(const RenderArguments& arguments, const Session& session,
                                     const CheckedPipeline& pipeline, const DeviceInfo& device,
                                     const RenderedFrames& frames, const std::vector<Finding>& findings,
                                     const OutputWriter& outputs, const std::vector<std::string>& warnings,
                                     const std::filesystem::path& shot_file);

// The same for people: milliseconds per pass, and the heap beside its bounds.
void print_summary(const nlohmann::ordered_json& report);

}  // namespace penumbra
