// SPDX-License-Identifier: MIT
// The project's own test scene: two rows of fluted columns with beams, railings, gratings, chains, steps and
// a gate that a shot can move. Casters stand at all heights over a plain floor, so that penumbrae grow from
// contact to wide.
#pragma once

#include "host/models/model.h"

namespace penumbra {

// About 160 000 triangles; metres, floor at y = 0, the nave along z. The node "gate" is meant to move.
Model make_colonnade();

}  // namespace penumbra
