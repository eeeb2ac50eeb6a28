// SPDX-License-Identifier: MIT
// Lights of the model (KHR_lights_punctual) that a shot names.
#pragma once

#include "host/shots/shot.h"

namespace penumbra {

class Scene;

// Gives each of the shot's lights that are the model's their kind, strength and a place for each frame. A
// name that no light of the model has is an error at the light's place.
bool place_model_lights(Shot& shot, const Scene& scene, Diagnostics& diagnostics);

}  // namespace penumbra
