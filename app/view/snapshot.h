// SPDX-License-Identifier: MIT
// What stands beside a screenshot: all that it takes to see the same again, and where things lay that can be
// clicked.
#pragma once

#include <string>

#include "app/view/live.h"

namespace penumbra::viewer {

// JSON: pipeline, settings (as --set takes them), size, resource, beside, the stance, judgement or null,
// error. `places` (see panels.h) by name.
std::string snapshot_text(const Live& live, const std::map<std::string, std::array<float, 2>>& places,
                          double frames_per_second);

}  // namespace penumbra::viewer
