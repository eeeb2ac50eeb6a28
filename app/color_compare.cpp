// SPDX-License-Identifier: MIT
#include "app/color_compare.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/progress.h"
#include "app/signal_files.h"
#include "app/wrong.h"
#include "host/json_dump.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

constexpr const char* colors[] = {"R", "G", "B"};

// Per channel, over receivers; coloured are those of which the truth says that some channel is not the
// visibility. A value that is no number counts as the worst error that it can have, as in a mask.
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
    const fs::path image_file = file_of_image(folder, arguments, frame),
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
        bool finite = true, coloured = false, known_here = true;
        for (size_t c = 0; c < 3; ++c) {
            const double is = double(seen[c][p]), should = double(known[c][p]);
            error[c] = std::isfinite(is) ? is - should : should > 0.5 ? -should : 1 - should;
            finite = finite && std::isfinite(is);
            coloured = coloured || std::abs(should - double(visibility[p])) > color_eps;
            known_here = known_here && std::isfinite(should);
        }
        sums.nonfinite += !finite || !known_here;
        if (!known_here) continue;  // nothing to hold it against
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
        std::cout << json_dump(json, 2) << "\n";
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

int compare_colors(const CompareArguments& arguments) {
    Diagnostics diagnostics;
    const auto frames = frames_to_compare(arguments, diagnostics);
    ColorErrors errors;
    std::vector<fs::path> folders{arguments.image};
    folders.insert(folders.end(), arguments.also.begin(), arguments.also.end());
    if (frames) {
        Progress progress("compare", frames->size() * folders.size());
        for (const uint32_t frame : *frames) {
            for (const fs::path& folder : folders) {
                add_colors(folder, arguments, frame, errors, diagnostics);
                progress.step();
            }
            if (!diagnostics.empty()) break;
        }
    }
    if (!diagnostics.empty()) return wrong(diagnostics);
    print(arguments, *frames, errors);
    return exit_good;
}

}  // namespace penumbra
