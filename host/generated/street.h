// SPDX-License-Identifier: MIT
// A scene for reflections at night.
#pragma once

#include "host/models/model.h"

namespace penumbra {

// A wet street between fronts with lit windows: puddles that mirror in asphalt that does not, ten bright
// bulbs of 7 cm that rays find by chance alone. The nodes "car" and "rear", its lights, are for a shot to
// move.
Model make_street();

}  // namespace penumbra
