// SPDX-License-Identifier: MIT
#include "app/signal_files.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/frame_range.h"
#include "app/mask_folder.h"

namespace penumbra {

namespace fs = std::filesystem;

namespace {

// What the images of a signal are called that was rendered.
std::vector<std::string> names_of_image(const CompareArguments& arguments) {
    if (arguments.light.empty()) return {arguments.signal};
    return {arguments.signal + "_" + arguments.light, arguments.signal + "s." + arguments.light};
}

bool has(const FramesByImage& images, const std::string& name, uint32_t frame) {
    const auto frames = images.find(name);
    return frames != images.end() && frames->second.contains(frame);
}

std::vector<uint32_t> frames_there(const CompareArguments& arguments, Diagnostics& diagnostics) {
    std::vector<uint32_t> frames;
    if (!arguments.frames.empty()) {
        const auto range = parse_frames(arguments.frames);
        for (uint32_t frame = range ? (*range)[0] : 1; range && frame <= (*range)[1]; ++frame)
            frames.push_back(frame);
        if (!range) diagnostics.add({}, "--frames", "not A..B: " + arguments.frames);
        return frames;
    }
    const auto truths = images_in(arguments.reference, diagnostics),
               images = images_in(arguments.image, diagnostics);
    if (!truths || !images) return frames;
    bool of_one_light = false;
    if (const auto known = truths->find(arguments.signal); known != truths->end())
        for (const uint32_t frame : known->second) {
            const auto is_of = [&](const std::string& name) { return has(*images, name, frame); };
            if (std::ranges::any_of(names_of_image(arguments), is_of)) frames.push_back(frame);
            of_one_light |= is_of(arguments.signal);
        }
    if (!frames.empty()) return frames;
    if (of_one_light)
        diagnostics.add(
            {}, "--light",
            fmt::format("chooses among images of several lights, and {} has {} of one: leave it out",
                        arguments.image, arguments.signal));
    else
        diagnostics.add({arguments.reference, 0, 0}, arguments.signal,
                        "shares no frame of this signal with " + arguments.image);
    return frames;
}

}  // namespace

fs::path file_of(const fs::path& folder, const std::string& signal, uint32_t frame) {
    return folder / fmt::format("{}.{:04}.exr", signal, frame);
}

fs::path file_of_image(const fs::path& folder, const CompareArguments& arguments, uint32_t frame) {
    fs::path file;
    for (const std::string& name : names_of_image(arguments)) {
        file = file_of(folder, name, frame);
        if (std::error_code none; fs::exists(file, none)) break;
    }
    return file;
}

std::optional<std::vector<uint32_t>> frames_to_compare(const CompareArguments& arguments,
                                                       Diagnostics& diagnostics) {
    for (const auto& [given, option] :
         {std::pair{!arguments.mask.empty(), "--mask"}, std::pair{arguments.border > 0, "--border"},
          std::pair{!arguments.whole_rays.empty(), "--whole-rays"}})
        if (given) diagnostics.add({}, option, "is of visibility alone");
    if (!arguments.light.empty() && arguments.signal != "transmittance")
        diagnostics.add({}, "--light", "is of visibility and transmittance alone");
    if (!diagnostics.empty()) return std::nullopt;
    auto frames = frames_there(arguments, diagnostics);
    return diagnostics.empty() ? std::optional(std::move(frames)) : std::nullopt;
}

std::span<const float> channel(const PlanarImage& image, const fs::path& file, const char* name,
                               Diagnostics& diagnostics) {
    const Plane* plane = image.find(name);
    if (plane && plane->type != PlaneType::uint) return plane->values;
    diagnostics.add({file.string(), 0, 0}, name,
                    plane ? "the channel holds integers" : "there is no such channel");
    return {};
}

bool same_size(const PlanarImage& image, const PlanarImage& truth, const fs::path& file,
               Diagnostics& diagnostics) {
    if (image.width == truth.width && image.height == truth.height) return true;
    diagnostics.add(
        {file.string(), 0, 0}, "",
        fmt::format("is {}x{}, the reference {}x{}", image.width, image.height, truth.width, truth.height));
    return false;
}

}  // namespace penumbra
