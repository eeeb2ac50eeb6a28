// SPDX-License-Identifier: MIT
// Visibility images as `render` and `reference` leave them in a folder: visibility.NNNN.exr and a word about
// the truth.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/images/image_file.h"
#include "host/metrics/contact.h"

namespace penumbra {

// What a frame's truth is the truth of.
struct ReferenceFrame {
    glm::dvec3 to_sun{0, 0, 1};          // unit, world axes
    std::array<double, 2> jitter{};      // uv: where in its pixels, from their centres
    std::optional<ContactLine> contact;  // where the scene says so
};

// reference.json: how good the truth is.
struct ReferenceInfo {
    std::string shot;
    std::array<uint32_t, 2> size{};
    bool exact = false;            // a closed form
    std::optional<uint32_t> rays;  // per pixel, else
    std::map<uint32_t, ReferenceFrame> frames;
    std::string light;  // whose visibility it is: the sun is one; empty: of none
};

void write_reference_info(const std::filesystem::path& folder, const ReferenceInfo& info);
std::optional<ReferenceInfo> read_reference_info(const std::filesystem::path& folder,
                                                 Diagnostics& diagnostics);

// What `render` says in report.json of the frames that it wrote.
struct RenderedFolder {
    std::filesystem::path shot;  // its file
    std::array<uint32_t, 2> size{};
    std::map<uint32_t, std::array<double, 2>> jitter;  // uv, per executed frame
    std::string light;  // that `visibility` is of; empty: of none, or nobody has said
};

std::optional<RenderedFolder> read_rendered_frames(const std::filesystem::path& folder,
                                                   Diagnostics& diagnostics);

// A frame that was rasterised off its pixels' centres shows other points than a truth of the centres does,
// and at a silhouette that is an error as large as any. Folders without a report say nothing of it; a truth
// that says nothing of its frames is one of centres.
void check_jitter(const std::filesystem::path& folder, const std::filesystem::path& reference,
                  const ReferenceInfo& info, const std::vector<uint32_t>& frames, Diagnostics& diagnostics);

// `light`: of a pipeline that takes several, whose mask is meant.
std::filesystem::path visibility_file(const std::filesystem::path& folder, uint32_t frame,
                                      const std::string& light = {});

// Frames of the images in a folder, by what they are called: 3 and "visibility" of visibility.0003.exr. An
// error where there is no such folder.
using FramesByImage = std::map<std::string, std::set<uint32_t>>;
std::optional<FramesByImage> images_in(const std::filesystem::path& folder, Diagnostics& diagnostics);

// Numbers of the visibility images in a folder, rising; an error where there are none.
std::optional<std::vector<uint32_t>> visibility_frames(const std::filesystem::path& folder,
                                                       Diagnostics& diagnostics,
                                                       const std::string& light = {});

}  // namespace penumbra
