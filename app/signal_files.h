// SPDX-License-Identifier: MIT
// Frames of a signal in folders, as `penumbra render` and `penumbra reference` write them, for commands that
// compare.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "app/commands.h"
#include "host/images/image_file.h"

namespace penumbra {

std::filesystem::path file_of(const std::filesystem::path& folder, const std::string& signal, uint32_t frame);

// Of what was rendered: where lights have one each, of `--light`, an image of its own or a layer.
std::filesystem::path file_of_image(const std::filesystem::path& folder, const CompareArguments& arguments,
                                    uint32_t frame);

// What folders say of themselves is said against each other: the reference is of the images' shot, and those
// of `--also` are the same images under other seeds. A folder without report.json or reference.json, which
// another program may have written, says nothing.
void check_folders(const CompareArguments& arguments, Diagnostics& diagnostics);

// Those that are asked for, else those that both folders have. An option that is of visibility alone is an
// error.
std::optional<std::vector<uint32_t>> frames_to_compare(const CompareArguments& arguments,
                                                       Diagnostics& diagnostics);

// A channel's values; empty, with an error, where there is none.
std::span<const float> channel(const PlanarImage& image, const std::filesystem::path& file, const char* name,
                               Diagnostics& diagnostics);

// Else an error.
bool same_size(const PlanarImage& image, const PlanarImage& truth, const std::filesystem::path& file,
               Diagnostics& diagnostics);

}  // namespace penumbra
