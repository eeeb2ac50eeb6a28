// SPDX-License-Identifier: MIT
#include "app/radiance_compare.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/frame_range.h"
#include "app/progress.h"
#include "host/images/image_file.h"
#include "host/metrics/radiance_error.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t most_frames = 10000;  // that a folder is looked through for

fs::path file_of(const fs::path& folder, const std::string& signal, uint32_t frame) {
    return folder / fmt::format("{}.{:04}.exr", signal, frame);
}

std::vector<uint32_t> frames_to_compare(const CompareArguments& arguments, Diagnostics& diagnostics) {
    std::vector<uint32_t> frames;
    if (!arguments.frames.empty()) {
        const auto range = parse_frames(arguments.frames);
        for (uint32_t frame = range ? (*range)[0] : 1; range && frame <= (*range)[1]; ++frame)
            frames.push_back(frame);
        if (!range) diagnostics.add({}, "--frames", "not A..B: " + arguments.frames);
        return frames;
    }
    for (uint32_t frame = 0; frame < most_frames; ++frame)
        if (fs::exists(file_of(arguments.reference, arguments.signal, frame)) &&
            fs::exists(file_of(arguments.image, arguments.signal, frame)))
            frames.push_back(frame);
    if (frames.empty())
        diagnostics.add({arguments.reference, 0, 0}, arguments.signal,
                        "shares no frame of this signal with " + arguments.image);
    return frames;
}

// A channel's values; empty, with an error, where there is none.
std::span<const float> channel(const PlanarImage& image, const fs::path& file, const char* name,
                               Diagnostics& diagnostics) {
    const Plane* plane = image.find(name);
    if (plane && plane->type != PlaneType::uint) return plane->values;
    diagnostics.add({file.string(), 0, 0}, name,
                    plane ? "the channel holds integers" : "there is no such channel");
    return {};
}

std::optional<RadianceErrorSums> compare_frame(const fs::path& folder, const CompareArguments& arguments,
                                               uint32_t frame, Diagnostics& diagnostics) {
    const fs::path image_file = file_of(folder, arguments.signal, frame),
                   truth_file = file_of(arguments.reference, arguments.signal, frame);
    const auto image = read_exr(image_file, diagnostics), truth = read_exr(truth_file, diagnostics);
    if (!image || !truth) return std::nullopt;
    if (image->width != truth->width || image->height != truth->height) {
        diagnostics.add({image_file.string(), 0, 0}, "",
                        fmt::format("is {}x{}, the reference {}x{}", image->width, image->height,
                                    truth->width, truth->height));
        return std::nullopt;
    }
    RadiancePlanes planes;
    RadianceTruth known;
    const char* colors[] = {"R", "G", "B"};
    for (size_t c = 0; c < 3; ++c) {
        planes.rgb[c] = channel(*image, image_file, colors[c], diagnostics);
        known.signal.rgb[c] = channel(*truth, truth_file, colors[c], diagnostics);
    }
    known.receiver = channel(*truth, truth_file, "receiver", diagnostics);
    known.roughness = channel(*truth, truth_file, "roughness", diagnostics);
    known.ray_error = channel(*truth, truth_file, "ray_error", diagnostics);
    known.noise = channel(*truth, truth_file, "noise", diagnostics);
    if (!diagnostics.empty()) return std::nullopt;
    return radiance_errors(planes, known);
}

nlohmann::ordered_json or_null(const std::optional<double>& value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

std::string text_of(const std::optional<double>& value) {
    return value ? fmt::format("{:.4g}", *value) : "-";
}

void print(const CompareArguments& arguments, const std::vector<uint32_t>& frames,
           const RadianceErrorSums& sums) {
    if (arguments.json) {
        nlohmann::ordered_json json = {{"image", arguments.image},
                                       {"reference", arguments.reference},
                                       {"signal", arguments.signal},
                                       {"frames", frames}};
        json["seeds"] = 1 + arguments.also.size();
        json["pixels"] = sums.pixels();
        json["n_eff"] = {{"value", or_null(sums.n_eff())}, {"by_roughness", nlohmann::ordered_json::array()}};
        for (size_t c = 0; c < roughness_classes; ++c)
            json["n_eff"]["by_roughness"].push_back(
                {{"to",
                  c < roughness_class_ends.size() ? std::round(roughness_class_ends[c] * 100) / 100 : 1},
                 {"pixels", sums.classes[c].pixels},
                 {"value", or_null(sums.n_eff(c))}});
        json["relmse"] = or_null(sums.relmse());
        json["bias"] = or_null(sums.bias());
        json["fireflies"] = sums.fireflies;
        json["nonfinite"] = sums.nonfinite;
        std::cout << json.dump(2) << "\n";
        return;
    }
    fmt::print("{} against {}: {}, {} frames, {} seeds, {} pixels\n", arguments.image, arguments.reference,
               arguments.signal, frames.size(), 1 + arguments.also.size(), sums.pixels());
    fmt::print("n_eff    {}   by roughness, to .05/.15/.3/.5/1:", text_of(sums.n_eff()));
    for (size_t c = 0; c < roughness_classes; ++c) fmt::print(" {}", text_of(sums.n_eff(c)));
    fmt::print("\nrelmse   {}   bias {}   fireflies {}   nonfinite {}\n", text_of(sums.relmse()),
               text_of(sums.bias()), sums.fireflies, sums.nonfinite);
}

}  // namespace

int compare_radiance(const CompareArguments& arguments) {
    Diagnostics diagnostics;
    for (const auto& [given, option] :
         {std::pair{!arguments.mask.empty(), "--mask"}, std::pair{arguments.border > 0, "--border"},
          std::pair{!arguments.whole_rays.empty(), "--whole-rays"}})
        if (given) diagnostics.add({}, option, "is of visibility, not of radiance");
    const std::vector<uint32_t> frames =
        diagnostics.empty() ? frames_to_compare(arguments, diagnostics) : std::vector<uint32_t>{};
    RadianceErrorSums sums;
    std::vector<fs::path> folders{arguments.image};
    folders.insert(folders.end(), arguments.also.begin(), arguments.also.end());
    {
        Progress progress("compare", frames.size() * folders.size());
        for (const uint32_t frame : frames)
            for (const fs::path& folder : folders) {
                if (const auto one = compare_frame(folder, arguments, frame, diagnostics)) sums.add(*one);
                progress.step();
            }
    }
    if (!diagnostics.empty()) {
        std::cerr << diagnostics.text();
        return exit_wrong;
    }
    print(arguments, frames, sums);
    return exit_good;
}

}  // namespace penumbra
