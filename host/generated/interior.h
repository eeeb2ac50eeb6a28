// SPDX-License-Identifier: MIT
// A scene for lamps.
#pragma once

#include "host/models/model.h"

namespace penumbra {

// A room of 6 by 4 by 2.8 metres, open towards +z: a table with things on it, two chairs, a shelf of books,
// and a grating before an opening in the left wall. The node "mobile" hangs from the ceiling for a shot to
// move.
Model make_interior();

}  // namespace penumbra
