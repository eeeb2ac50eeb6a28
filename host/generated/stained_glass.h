// SPDX-License-Identifier: MIT
// A scene of what lets light through.
#pragma once

#include "host/models/model.h"

namespace penumbra {

// A room of 6 by 5 by 3.2 metres, open towards +z, with a window of coloured panes between leads in its right
// wall (alphaMode BLEND and KHR_materials_transmission), a lattice of opaque bars outside of it, two sheets
// of glass that overlap on a stand, the node "sheet" for a shot to move, and a lace curtain whose texture's
// alpha is its threads.
Model make_stained_glass();

}  // namespace penumbra
