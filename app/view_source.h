// SPDX-License-Identifier: MIT
// What a command looks at: a shot by file or shipped name, or a model that a shot is made up for.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/commands.h"
#include "host/shots/shot.h"

namespace penumbra {

bool is_model_file(const std::string& name);  // by its ending

struct ViewSource {
    Shot shot;
    // Of a shot that was made up: its text, to be written as shot.file. It stands in the folder that was
    // given.
    std::string made_up;
};

// `folder`: where a made-up shot will stand. Errors go to `diagnostics`; what is to be said about a model
// goes to stderr.
std::optional<ViewSource> open_view(const ViewArguments& arguments, const std::filesystem::path& folder,
                                    Diagnostics& diagnostics);

// NAME of MODEL.glb or NAME.shot.json.
std::string view_name(const ViewArguments& arguments);

}  // namespace penumbra
