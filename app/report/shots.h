// SPDX-License-Identifier: MIT
// The shots that a report looks at, as files beside it, so that each figure can be repeated by hand: a shot
// as it is, the same standing still (every list of keys cut to its first, no animation), and straight edges
// that move.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/input_files.h"
#include "host/shots/shot.h"

namespace penumbra::report {

// Both are ordinary shots; `still` is `moving` with nothing that moves.
struct ReportShot {
    std::string name;
    Shot moving;
    std::optional<Shot> still;
};

struct EdgeShot {
    double width_px = 0, speed_px = 0;
    Shot shot;
};

// Before anything is written into a report's folder: false, with an error, where two shots have one name,
// which figures and files are called by, or where a file there is one that is read.
bool can_be_reported(const std::filesystem::path& folder, const FileList& shots,
                     const std::vector<std::string>& pipelines, const std::vector<std::string>& node_folders,
                     Diagnostics& diagnostics);

// As read_completed_shot(). Writes FOLDER/NAME.still.shot.json. `frames`: how long it lasts; 0: there is
// none.
std::optional<ReportShot> open_report_shot(const std::filesystem::path& file,
                                           const std::filesystem::path& folder, uint32_t frames,
                                           Diagnostics& diagnostics);

// Leaves nothing but the light of this name; false, with diagnostics, where there is none.
bool keep_light_alone(const std::string& light, ReportShot& shot, Diagnostics& diagnostics);

// Writes FOLDER/edge_16px_+0.25.shot.json: a half-plane whose penumbra's middle is the image's at `frame`.
EdgeShot make_edge_shot(double width_px, double speed_px, uint32_t frame, const std::filesystem::path& folder,
                        Diagnostics& diagnostics);

}  // namespace penumbra::report
