// SPDX-License-Identifier: MIT
// What numbers alone show to be wrong in a host's description of a frame. Each would be a picture that is
// black or noise, with nothing to tell why.
#pragma once

#include "penumbra/frame_block.h"
#include "penumbra/plan.h"

namespace penumbra {

// Throws a Failure of ErrorCode::usage that names the member. `has_past`: a frame before was recorded, by
// this view or the one that it is the heir of.
void check_frame(const FrameDescription& frame, const Plan& plan, bool has_past);

}  // namespace penumbra
