// SPDX-License-Identifier: MIT
// A shot for a model that nobody has written one for.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "host/models/model.h"
#include "host/shots/shot.h"

namespace penumbra {

// Seen by the file's first camera, or as large as it fits from the front, the left and above; lit by the
// file's first directional light, or from behind the viewer's left shoulder, and by its lamps; playing the
// file's first animation that takes any time once, or standing still for as long as anti-aliasing takes to
// settle.
struct ModelShot {
    std::string text;                    // a shot file; `scene` as seen from the folder that it was made for
    std::array<glm::dvec3, 2> bounds{};  // of everything that is shown, over all frames
    std::string camera;                  // the node whose camera is looked through; empty: one that sees all
    // What of the model is not in it, by the shot's key; by "scene" what is in it and not drawn.
    std::multimap<std::string, std::string> warnings;
};

// `file` as a shot names it that stands in `folder` (empty: the current one).
std::string seen_from(const std::filesystem::path& file, const std::filesystem::path& folder);

// `model` is what `file` holds, with at least one triangle; `shot_folder` is where the shot will stand.
// `played`: the frames, their time and the animation that it has already, instead of those above.
ModelShot make_model_shot(const Model& model, const std::filesystem::path& file,
                          const std::filesystem::path& shot_folder, bool ground,
                          const Shot* played = nullptr);

}  // namespace penumbra
