// SPDX-License-Identifier: MIT
// The model that a shot looks at: a file's, or several files' as one.
#pragma once

#include <optional>

#include "host/models/model.h"
#include "host/shots/shot.h"
#include "penumbra/diagnostic.h"

namespace penumbra {

// `model` below a node of its own at `place`, behind what `all` holds. Names of its nodes, lights and
// animations get `place.name` and a slash before them; warnings its file.
void join_model(Model& all, Model model, const PlacedModel& place);

// What a shot's files hold; nothing, with a diagnostic, where one cannot be read, or where none has a
// triangle. An analytic scene has no files: nothing.
std::optional<Model> load_models(const Shot& shot, Diagnostics& diagnostics);

}  // namespace penumbra
