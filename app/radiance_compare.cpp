// SPDX-License-Identifier: MIT
#include "app/radiance_compare.h"

#include <fmt/format.h>

#include <array>
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

constexpr std::array<const char*, 3> colors = {"R", "G", "B"};
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

bool same_size(const PlanarImage& image, const PlanarImage& truth, const fs::path& file,
               Diagnostics& diagnostics) {
    if (image.width == truth.width && image.height == truth.height) return true;
    diagnostics.add(
        {file.string(), 0, 0}, "",
        fmt::format("is {}x{}, the reference {}x{}", image.width, image.height, truth.width, truth.height));
    return false;
}

std::optional<RadianceErrorSums> compare_frame(const fs::path& folder, const CompareArguments& arguments,
                                               uint32_t frame, Diagnostics& diagnostics) {
    const fs::path image_file = file_of(folder, arguments.signal, frame),
                   truth_file = file_of(arguments.reference, arguments.signal, frame);
    const auto image = read_exr(image_file, diagnostics), truth = read_exr(truth_file, diagnostics);
    if (!image || !truth || !same_size(*image, *truth, image_file, diagnostics)) return std::nullopt;
    RadiancePlanes planes;
    RadianceTruth known;
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

// Per channel, over receivers; coloured are those of which the truth says that some channel is not the
// visibility.
struct ColorErrors {
    struct Sum {
        uint64_t pixels = 0;
        std::array<double, 3> squares{}, errors{};

        void add(const std::array<double, 3>& error) {
            ++pixels;
            for (size_t c = 0; c < 3; ++c) {
                squares[c] += error[c] * error[c];
                errors[c] += error[c];
            }
        }
    };
    Sum all, coloured;
    uint64_t nonfinite = 0;
};

constexpr double color_eps = 1e-3;

void add_colors(const fs::path& folder, const CompareArguments& arguments, uint32_t frame, ColorErrors& sums,
                Diagnostics& diagnostics) {
    const fs::path image_file = file_of(folder, arguments.signal, frame),
                   truth_file = file_of(arguments.reference, arguments.signal, frame);
    const auto image = read_exr(image_file, diagnostics), truth = read_exr(truth_file, diagnostics);
    if (!image || !truth || !same_size(*image, *truth, image_file, diagnostics)) return;
    std::array<std::span<const float>, 3> seen, known;
    for (size_t c = 0; c < 3; ++c) {
        seen[c] = channel(*image, image_file, colors[c], diagnostics);
        known[c] = channel(*truth, truth_file, colors[c], diagnostics);
    }
    const auto receiver = channel(*truth, truth_file, "receiver", diagnostics),
               visibility = channel(*truth, truth_file, "visibility", diagnostics);
    if (!diagnostics.empty()) return;
    for (size_t p = 0; p < receiver.size(); ++p) {
        if (!(receiver[p] > 0.5f)) continue;
        std::array<double, 3> error{};
        bool finite = true, coloured = false;
        for (size_t c = 0; c < 3; ++c) {
            error[c] = double(seen[c][p]) - double(known[c][p]);
            finite = finite && std::isfinite(error[c]);
            coloured = coloured || std::abs(double(known[c][p]) - double(visibility[p])) > color_eps;
        }
        if (!finite) ++sums.nonfinite;
        if (!finite) continue;
        sums.all.add(error);
        if (coloured) sums.coloured.add(error);
    }
}

void print(const CompareArguments& arguments, const std::vector<uint32_t>& frames, const ColorErrors& sums) {
    const auto mean = [](const ColorErrors::Sum& sum, const std::array<double, 3>& of, bool root) {
        nlohmann::ordered_json out;
        for (size_t c = 0; c < 3; ++c)
            out[colors[c]] = sum.pixels == 0
                                 ? nlohmann::ordered_json()
                                 : nlohmann::ordered_json(root ? std::sqrt(of[c] / double(sum.pixels))
                                                               : of[c] / double(sum.pixels));
        return out;
    };
    const auto described = [&](const ColorErrors::Sum& sum) {
        return nlohmann::ordered_json{{"pixels", sum.pixels},
                                      {"rmse", mean(sum, sum.squares, true)},
                                      {"bias", mean(sum, sum.errors, false)}};
    };
    nlohmann::ordered_json json = {{"image", arguments.image},   {"reference", arguments.reference},
                                   {"signal", arguments.signal}, {"frames", frames},
                                   {"all", described(sums.all)}, {"coloured", described(sums.coloured)},
                                   {"nonfinite", sums.nonfinite}};
    if (arguments.json) {
        std::cout << json.dump(2) << "\n";
        return;
    }
    fmt::print("{} against {}: {}, {} frames\n", arguments.image, arguments.reference, arguments.signal,
               frames.size());
    for (const char* of : {"all", "coloured"}) {
        fmt::print("{:8} {} pixels", of, json[of]["pixels"].dump());
        for (const char* what : {"rmse", "bias"}) {
            fmt::print("   {}", what);
            for (const char* color : colors) {
                const auto& value = json[of][what][color];
                fmt::print(" {} {}", color,
                           value.is_null() ? "-" : fmt::format("{:.4g}", value.get<double>()));
            }
        }
        fmt::print("\n");
    }
    fmt::print("defects  not finite {}\n", sums.nonfinite);
}

}  // namespace

int compare_radiance(const CompareArguments& arguments) {
    Diagnostics diagnostics;
    for (const auto& [given, option] :
         {std::pair{!arguments.mask.empty(), "--mask"}, std::pair{arguments.border > 0, "--border"},
          std::pair{!arguments.whole_rays.empty(), "--whole-rays"}})
        if (given) diagnostics.add({}, option, "is of visibility alone");
    const std::vector<uint32_t> frames =
        diagnostics.empty() ? frames_to_compare(arguments, diagnostics) : std::vector<uint32_t>{};
    RadianceErrorSums sums;
    ColorErrors color_errors;
    const bool of_light = arguments.signal == "transmittance";
    std::vector<fs::path> folders{arguments.image};
    folders.insert(folders.end(), arguments.also.begin(), arguments.also.end());
    {
        Progress progress("compare", frames.size() * folders.size());
        for (const uint32_t frame : frames)
            for (const fs::path& folder : folders) {
                if (of_light)
                    add_colors(folder, arguments, frame, color_errors, diagnostics);
                else if (const auto one = compare_frame(folder, arguments, frame, diagnostics))
                    sums.add(*one);
                progress.step();
            }
    }
    if (!diagnostics.empty()) {
        std::cerr << diagnostics.text();
        return exit_wrong;
    }
    if (of_light)
        print(arguments, frames, color_errors);
    else
        print(arguments, frames, sums);
    return exit_good;
}

}  // namespace penumbra
