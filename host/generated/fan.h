// SPDX-License-Identifier: MIT
// A test scene of fast shadows: two fans turn between the sun and a floor, one upright in a wall, one flat
// under a roof of slats. Their blades' shadows sweep the floor while nothing that receives them moves.
#pragma once

#include "host/models/model.h"

namespace penumbra {

// About 6 000 triangles; nodes "fan_wall" (turns about z) and "fan_ceiling" (about y) are meant to move.
Model make_fan();

}  // namespace penumbra
