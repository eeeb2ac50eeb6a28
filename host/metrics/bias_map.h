// SPDX-License-Identifier: MIT
// Systematic error without noise: the largest error of the seeds' mean, averaged over 9x9 pixels. A filter
// that bends every penumbra a little shows here long before it does in the root mean square.
#pragma once

#include <optional>

#include "host/metrics/compared_frame.h"

namespace penumbra {

// max |box mean of (mean of the seeds - truth)|; boxes of which less than half counts are left out. Absent
// where no box is left.
std::optional<double> largest_bias_9x9(const ComparedFrame& frame);

}  // namespace penumbra
