// SPDX-License-Identifier: MIT
// The scene that a shot names: from its model's file, or made, with the ground that it asks for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/scene/scene.h"
#include "host/shots/shot.h"
#include "penumbra/diagnostic.h"

namespace penumbra {

// Nothing, with a diagnostic, where it cannot be read or takes more than input_limit(); warnings about it go
// to `warnings`.
std::optional<Scene> load_scene(const Shot& shot, Diagnostics& diagnostics,
                                std::vector<std::string>& warnings);

}  // namespace penumbra
