// SPDX-License-Identifier: MIT
// Scenes for reflections.
#pragma once

#include "host/models/model.h"

namespace penumbra {

// An open court whose floor is a mirror at one end and rough at the other, between checkered and striped
// walls; poles and a small bright lamp, which rays find by chance alone. The node "carriage" is for a shot to
// move.
Model make_polished();

// Spheres of metal on a tiled floor, from chrome to rough, one row of them coloured; a lit panel.
Model make_chrome();

}  // namespace penumbra
