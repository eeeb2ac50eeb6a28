// SPDX-License-Identifier: MIT
// Which of a shot's lights a pipeline is run for, and whether its plan is one for them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/shots/light_choice.h"
#include "penumbra/graph.h"

namespace penumbra {

struct SessionLights {
    ChosenLight chosen;              // whom masks are of, where they are of one light
    std::vector<std::string> names;  // of the lights that are brought together or each
    bool together = false;           // in the input "lights"
    bool each = false;               // in an input of its own: "light_NAME"
};

// `wanted`: a name, or empty, as for choose_light(). Nothing after an error.
std::optional<SessionLights> choose_session_lights(const CheckedPipeline& pipeline, const Shot& shot,
                                                   const std::string& wanted, Diagnostics& diagnostics);

// A pipeline is for the sun or for lights that are near, and so is every node of it that asks for a light:
// the other is an error. `light`: the chosen one, where the shot is now; nullptr is the sun.
void check_lights(const Plan& plan, const CheckedPipeline& pipeline, const SessionLights& lights,
                  const ShotLight* light, Diagnostics& diagnostics);

}  // namespace penumbra
