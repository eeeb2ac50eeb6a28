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
    std::string text;    // of any shot, with what of it was made up
    std::string camera;  // of one that was made up: the model's node that it is seen from; else empty
};

// What somebody names without saying what it is: a pipeline, a model, or both, beside what --shot and --model
// say.
struct GivenFiles {
    std::string pipeline;  // may be none
    ViewArguments view;
};
// Two of a kind are an error.
std::optional<GivenFiles> sort_files(const std::vector<std::string>& files, const ViewArguments& view,
                                     Diagnostics& diagnostics);

// The pipeline that is named, else hybrid_shadows; or lights, for a shot that has no sun.
std::string pipeline_for(const GivenFiles& given, const Shot* shot);

// `folder`: where a made-up shot will stand. Errors go to `diagnostics`; what is to be said about a model
// goes to stderr.
std::optional<ViewSource> open_view(const ViewArguments& arguments, const std::filesystem::path& folder,
                                    Diagnostics& diagnostics);

// read_shot(), where a shot of a model that leaves out its camera, or sun and lights, gets those that a shot
// would have that is made up for the model. `text`: what was parsed, with these.
std::optional<Shot> read_completed_shot(const std::filesystem::path& file, Diagnostics& diagnostics,
                                        std::string* text = nullptr);

// NAME of MODEL.glb or NAME.shot.json.
std::string view_name(const ViewArguments& arguments);

}  // namespace penumbra
