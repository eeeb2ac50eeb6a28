// SPDX-License-Identifier: MIT
// The list of scenes that the project makes itself: scenes/<name>.glb comes from make().
#pragma once

#include <array>

#include "host/generated/colonnade.h"
#include "host/generated/fan.h"
#include "host/generated/heightfield.h"
#include "host/generated/interior.h"
#include "host/generated/lamp.h"
#include "host/generated/polished.h"
#include "host/generated/stained_glass.h"
#include "host/generated/street.h"
#include "host/generated/trees.h"

namespace penumbra {

struct GeneratedScene {
    const char* name;
    Model (*make)();
};

inline constexpr std::array<GeneratedScene, 11> generated_scenes{{{"cards", make_cards},
                                                                  {"colonnade", make_colonnade},
                                                                  {"fan", make_fan},
                                                                  {"heightfield", make_heightfield},
                                                                  {"interior", make_interior},
                                                                  {"lamp", make_lamp},
                                                                  {"chrome", make_chrome},
                                                                  {"polished", make_polished},
                                                                  {"stained_glass", make_stained_glass},
                                                                  {"street", make_street},
                                                                  {"trees", make_trees}}};

}  // namespace penumbra
