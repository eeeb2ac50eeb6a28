// SPDX-License-Identifier: MIT
// A test scene of large triangles: a square kilometre of hills in cells of 12.5 m on a plain of two
// triangles, 8 km across, under a low sun, with a power line whose wires are far narrower than any shadow
// map's texel.
#pragma once

#include "host/models/model.h"

namespace penumbra {

// About 25 000 triangles; nodes "hills", "plain", "pylon_0" .. "pylon_4", "wires", "barn". Nothing moves.
Model make_heightfield();

}  // namespace penumbra
