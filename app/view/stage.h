// SPDX-License-Identifier: MIT
// One pipeline that runs in the view, with all that it was made of.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "app/session.h"
#include "app/view/controls.h"

namespace penumbra::viewer {

// What one shot's stages are made on.
struct StagePlace {
    Device& device;
    const Shot& shot;
    KeptScene& scene;
    const Told& told;  // what is being done
};

struct StageWish {
    std::string pipeline;  // a file, or the name of a shipped one
    std::vector<std::string> settings, node_folders;
    std::array<uint32_t, 2> size{640, 360};
    std::string light;             // as render's --light
    std::optional<uint32_t> seed;  // instead of the shot's
    std::string shown;  // a resource to look at beside the outputs; left out where there is none of it
};

struct Stage {
    NodeSet nodes;
    CheckedPipeline pipeline;
    std::unique_ptr<Session> session;
    std::vector<Control> controls;
    std::set<std::filesystem::path> files;  // that the pipeline was read from
    bool fresh = true;                      // no frame has run yet
};

// What `make` throws is a diagnostic of `what`, a file or a few words: whoever looks goes on without it.
void diagnose_thrown(const std::string& what, Diagnostics& diagnostics, const std::function<void()>& make);

// Everything but the scene is read anew. What a device fails with is a diagnostic, too: the view goes on
// without this stage.
std::unique_ptr<Stage> open_stage(const StagePlace& place, const StageWish& wish, Diagnostics& diagnostics,
                                  std::vector<std::string>& warnings);

// Names that a frame of the stage can be asked for: what its passes write, and the G-buffer.
std::vector<std::string> resources_of(const Stage& stage);

}  // namespace penumbra::viewer
