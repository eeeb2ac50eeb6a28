// SPDX-License-Identifier: MIT
// Which lights a frame can do without.
#pragma once

#include "host/shots/light_choice.h"
#include "penumbra/frame_block.h"

namespace penumbra {

// False: the light is off, or the ball that it reaches lies outside of the picture, and of a pixel around it
// for the jitter. (Some such balls that touch the planes of two of the picture's sides behind their edge are
// let through.)
bool may_show(const blocks::Light& light, const Camera& camera);

}  // namespace penumbra
