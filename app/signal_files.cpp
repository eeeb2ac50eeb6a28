// SPDX-License-Identifier: MIT
#include "app/signal_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/frame_range.h"
#include "app/is_there.h"
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
        const auto range = parse_frames(arguments.frames, diagnostics);
        for (uint32_t frame = range ? (*range)[0] : 1; range && frame <= (*range)[1]; ++frame)
            frames.push_back(frame);
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
    else if (truths->contains(arguments.signal) &&
             std::ranges::none_of(names_of_image(arguments),
                                  [&](const std::string& name) { return images->contains(name); }))
        diagnostics.add({arguments.image, 0, 0}, arguments.signal,
                        "there is no image of it: render with --capture " + arguments.signal);
    else
        diagnostics.add({arguments.reference, 0, 0}, arguments.signal,
                        "shares no frame of this signal with " + arguments.image);
    return frames;
}

// Null where there is none, or none that can be read.
nlohmann::json said_in(const fs::path& file) {
    std::ifstream stream(file);
    auto json = nlohmann::json::parse(stream, nullptr, false);
    return json.is_object() ? json : nlohmann::json();
}

// Empty where it is not said.
std::string word_of(const nlohmann::json& said, const char* key) {
    const auto word = said.find(key);
    return word != said.end() && word->is_string() ? word->get<std::string>() : "";
}

// The name of a shot's file: the way to it is another one from elsewhere, or nothing where a model stands for
// one.
std::string shot_of(const nlohmann::json& said, const char* key) {
    return fs::path(word_of(said, key)).filename().string();
}

bool of_a_light(const std::string& signal) {
    return signal == "visibility" || signal == "transmittance";
}

// Nothing where they agree, or one of them does not say.
std::string first_difference(const nlohmann::json& a, const nlohmann::json& b) {
    for (const char* key : {"pipeline", "shot", "light", "size", "settings"})
        if (a.contains(key) && b.contains(key) && a[key] != b[key]) return key;
    return "";
}

}  // namespace

void check_folders(const CompareArguments& arguments, Diagnostics& diagnostics) {
    std::vector<std::string> folders{arguments.image};
    folders.insert(folders.end(), arguments.also.begin(), arguments.also.end());
    const nlohmann::json truth_said = said_in(fs::path(arguments.reference) / "reference.json");
    const std::string truth = shot_of(truth_said, "shot"), truths_light = word_of(truth_said, "light");
    std::vector<nlohmann::json> reports;
    for (size_t i = 0; i < folders.size(); ++i) {
        const auto refuse = [&](const char* key, const std::string& why) {
            diagnostics.add({folders[i], 0, 0}, key, why);
        };
        const auto& report = reports.emplace_back(said_in(fs::path(folders[i]) / "report.json"));
        const std::string shot = shot_of(report, "shot_file");
        if (!shot.empty() && !truth.empty() && shot != truth)
            refuse("", fmt::format("shows {}, the reference {} is of {}", shot, arguments.reference, truth));
        const std::string light = arguments.light.empty() ? word_of(report, "light") : arguments.light;
        if (of_a_light(arguments.signal) && !light.empty() && !truths_light.empty() && light != truths_light)
            refuse("light", fmt::format("is \"{}\", the reference {} is of \"{}\"", light,
                                        arguments.reference, truths_light));
        if (i == 0) continue;
        const std::string other = first_difference(reports[0], report);
        if (!other.empty())
            refuse(other.c_str(), fmt::format("is not that of {}: --also takes the same images under another "
                                              "seed",
                                              folders[0]));
        for (size_t before = 0; before < i; ++before) {
            std::error_code none;
            if (fs::equivalent(folders[before], folders[i], none))
                refuse("--also", "this folder is given twice");
            else if (report.contains("seed") && reports[before].contains("seed") &&
                     report["seed"] == reports[before]["seed"])
                refuse("seed", fmt::format("is {} in {}, too: --also takes another seed",
                                           report["seed"].dump(), folders[before]));
        }
    }
}

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
    if (diagnostics.empty()) check_folders(arguments, diagnostics);
    if (!diagnostics.empty()) return std::nullopt;
    auto frames = frames_there(arguments, diagnostics);
    const fs::path truth = arguments.reference;
    auto info = is_there(truth / "reference.json", diagnostics) ? read_reference_info(truth, diagnostics)
                                                                : std::nullopt;
    if (info) {
        // What the file says of frames is said of visibility; a truth of radiance is always one of centres.
        if (!of_a_light(arguments.signal)) info->frames.clear();
        check_jitter(arguments.image, truth, *info, frames, diagnostics);
        for (const std::string& folder : arguments.also)
            check_jitter(folder, truth, *info, frames, diagnostics);
    }
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
