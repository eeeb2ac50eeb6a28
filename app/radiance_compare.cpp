// SPDX-License-Identifier: MIT
#include "app/radiance_compare.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/input_files.h"
#include "app/lit_picture.h"
#include "app/metrics_json.h"
#include "app/or_null.h"
#include "app/progress.h"
#include "app/radiance_json.h"
#include "app/signal_files.h"
#include "app/wrong.h"
#include "host/images/image_file.h"
#include "host/json_dump.h"
#include "host/metrics/radiance_error.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

struct ComparedImages {
    PlanarImage image, truth;
    RadiancePlanes shown;
    RadianceTruth known;
};

std::unique_ptr<ComparedImages> read_frame(const fs::path& folder, const CompareArguments& arguments,
                                           uint32_t frame, Diagnostics& diagnostics) {
    const fs::path image_file = file_of(folder, arguments.signal, frame),
                   truth_file = file_of(arguments.reference, arguments.signal, frame);
    auto image = read_exr(image_file, diagnostics), truth = read_exr(truth_file, diagnostics);
    if (!image || !truth || !same_size(*image, *truth, image_file, diagnostics)) return nullptr;
    auto out = std::make_unique<ComparedImages>();
    out->image = std::move(*image);
    out->truth = std::move(*truth);
    const char* colors[] = {"R", "G", "B"};
    for (size_t c = 0; c < 3; ++c) {
        out->shown.rgb[c] = channel(out->image, image_file, colors[c], diagnostics);
        out->known.signal.rgb[c] = channel(out->truth, truth_file, colors[c], diagnostics);
    }
    out->known.width = out->truth.width;
    out->known.receiver = channel(out->truth, truth_file, "receiver", diagnostics);
    out->known.roughness = channel(out->truth, truth_file, "roughness", diagnostics);
    out->known.ray_error = channel(out->truth, truth_file, "ray_error", diagnostics);
    out->known.noise = channel(out->truth, truth_file, "noise", diagnostics);
    return diagnostics.empty() ? std::move(out) : nullptr;
}

// Over all frames of a folder, up to the first that is missing; frames that follow on each other also show
// what flickers.
RadianceErrorSums compare_folder(const fs::path& folder, const CompareArguments& arguments,
                                 const std::vector<uint32_t>& frames, Progress& progress,
                                 Diagnostics& diagnostics) {
    RadianceErrorSums sums;
    std::unique_ptr<ComparedImages> before;
    uint32_t last = 0;
    for (const uint32_t frame : frames) {
        auto now = read_frame(folder, arguments, frame, diagnostics);
        progress.step();
        if (!now) break;
        const bool follows =
            before && frame == last + 1 && before->known.receiver.size() == now->known.receiver.size();
        sums.add(follows ? radiance_errors(now->shown, now->known, before->shown, before->known.signal)
                         : radiance_errors(now->shown, now->known));
        before = std::move(now);
        last = frame;
    }
    return sums;
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
        json.update(radiance_json(sums));
        std::cout << json_dump(json, 2) << "\n";
        return;
    }
    fmt::print("{} against {}: {}, {} frames, {} seeds, {} pixels\n", arguments.image, arguments.reference,
               arguments.signal, frames.size(), 1 + arguments.also.size(), sums.pixels());
    fmt::print("n_eff    {}   by roughness, to .05/.15/.3/.5/1:", text_of(sums.n_eff()));
    for (size_t c = 0; c < roughness_classes; ++c) fmt::print(" {}", text_of(sums.n_eff(c)));
    fmt::print("\nrelmse   {}   bias {}   flicker {}   fireflies {}   nonfinite {}\n", text_of(sums.relmse()),
               text_of(sums.bias()), text_of(sums.flicker()), sums.fireflies, sums.nonfinite);
}

// --picture is no image that is compared.
bool spares_images(const CompareArguments& arguments, const std::vector<uint32_t>& frames,
                   Diagnostics& diagnostics) {
    FileList read;
    for (const uint32_t frame : frames) {
        for (const std::string& folder : {arguments.image, arguments.reference})
            read.push_back(file_of(folder, arguments.signal, frame));
        if (std::error_code none; !fs::exists(read.back(), none)) break;  // which ends the comparison, too
    }
    return spares({arguments.picture}, {read}, diagnostics);
}

}  // namespace

int compare_radiance(const CompareArguments& arguments) {
    Diagnostics diagnostics;
    const auto frames = frames_to_compare(arguments, diagnostics);
    if (!frames) return wrong(diagnostics);
    RadianceErrorSums sums;
    std::vector<fs::path> folders{arguments.image};
    folders.insert(folders.end(), arguments.also.begin(), arguments.also.end());
    {
        Progress progress("compare", frames->size() * folders.size());
        for (const fs::path& folder : folders)
            if (diagnostics.empty())
                sums.add(compare_folder(folder, arguments, *frames, progress, diagnostics));
    }
    if (!diagnostics.empty()) return wrong(diagnostics);
    print(arguments, *frames, sums);
    return exit_good;
}

int compare_pictures(const CompareArguments& arguments) {
    Diagnostics diagnostics;
    if (!arguments.also.empty()) diagnostics.add({}, "--also", "is of signals, not of pictures");
    const auto frames = frames_to_compare(arguments, diagnostics);
    if (!frames || !spares_images(arguments, *frames, diagnostics)) return wrong(diagnostics);
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const uint32_t frame : *frames) {
        const fs::path truth_file = file_of(arguments.reference, arguments.signal, frame);
        const auto image = read_picture(file_of(arguments.image, arguments.signal, frame), diagnostics),
                   truth = read_picture(truth_file, diagnostics);
        if (!image || !truth || !is_finite(*truth, truth_file, diagnostics)) return wrong(diagnostics);
        if (image->width != truth->width || image->height != truth->height) {
            diagnostics.add({arguments.image, 0, 0}, "", "is of another size than the reference");
            return wrong(diagnostics);
        }
        const PictureError error = picture_error(*image, *truth);
        list.push_back({{"frame", frame},
                        {"relmse", error.relmse},
                        {"bias", or_null(error.bias)},
                        {"flip", flip_json(error.flip)},
                        {"nonfinite", error.nonfinite}});
        if (!arguments.json)
            fmt::print(
                "frame {}   relmse {:.4g}   bias {}   flip mean {:.4g} weighted median {:.4g} p95 {:.4g}   "
                "nonfinite {}\n",
                frame, error.relmse, text_of(error.bias), error.flip.mean, error.flip.weighted_median,
                error.flip.p95, error.nonfinite);
        if (!arguments.picture.empty()) write_beside(arguments.picture, *image, *truth);
    }
    if (arguments.json)
        std::cout << json_dump(nlohmann::ordered_json{{"image", arguments.image},
                                                      {"reference", arguments.reference},
                                                      {"signal", arguments.signal},
                                                      {"frames", list}},
                               2)
                  << "\n";
    return exit_good;
}

}  // namespace penumbra
