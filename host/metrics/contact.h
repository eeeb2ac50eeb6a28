// SPDX-License-Identifier: MIT
// Peter-panning: the gap between an object and a shadow that should start right at it.
#pragma once

#include <array>
#include <optional>

#include "host/metrics/compared_frame.h"

namespace penumbra {

// Where an object stands on its receiver, in pixels from the image's top left corner, y down; `away` is the
// unit vector in which the shadow falls. A point: from = to.
struct ContactLine {
    std::array<double, 2> from{}, to{}, away{};
};

// Mean distance from the line to the first pixel darker than a half, minus the same distance in the truth.
// Absent where the truth has no shadow at the line.
std::optional<double> peter_panning_px(const ComparedFrame& frame, const ContactLine& line);

}  // namespace penumbra
