// SPDX-License-Identifier: MIT
// What numbers alone show to be wrong in a host's description of a frame. Each would be a picture that is
// black or noise, with nothing to tell why.
#pragma once

#include "penumbra/frame_block.h"

namespace penumbra {

// Throws a Failure of ErrorCode::usage that names the member. `reads_previous`: there is a frame before.
void check_frame(const FrameDescription& frame, bool reads_previous);

}  // namespace penumbra
