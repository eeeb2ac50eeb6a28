// SPDX-License-Identifier: MIT
// A test scene of moving casters that are not spinning: a lamp swings from its post while figures walk below.
// The figures are rigid parts on joints; the motion is keys of a shot, made by make_lamp_shot().
#pragma once

#include <string>

#include "host/models/model.h"

namespace penumbra {

// About 12 000 triangles. Nodes that move: "lamp"; "walker_0" .. "walker_2" and their joints
// "walker_0_thigh_left" ...
Model make_lamp();

// scenes/lamp.shot.json: 64 frames, the camera still.
std::string make_lamp_shot();

}  // namespace penumbra
