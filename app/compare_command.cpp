// SPDX-License-Identifier: MIT
// penumbra compare: a rendered visibility against a reference, frame by frame. Which pixels are receivers and
// which lie in the penumbra is the reference's word, never the pipeline's own verdict.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/frame_range.h"
#include "app/mask_folder.h"
#include "host/metrics.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

struct Comparison {
    std::vector<uint32_t> frames;
    ReferenceInfo truth;
    MaskMetrics metrics;
};

// Frames to compare: those asked for, else those that all folders have.
std::optional<std::vector<uint32_t>> choose_frames(const CompareArguments& arguments,
                                                   const std::vector<fs::path>& images,
                                                   Diagnostics& diagnostics) {
    if (!arguments.frames.empty()) {
        const auto range = parse_frames(arguments.frames, 1);
        if (!range) return std::nullopt;
        std::vector<uint32_t> frames;
        for (uint32_t frame = (*range)[0]; frame <= (*range)[1]; ++frame) frames.push_back(frame);
        return frames;
    }
    auto frames = visibility_frames(arguments.reference, diagnostics);
    for (const fs::path& folder : images) {
        const auto present = visibility_frames(folder, diagnostics);
        if (!frames || !present) return std::nullopt;
        std::erase_if(*frames, [&](uint32_t frame) {
            return !std::binary_search(present->begin(), present->end(), frame);
        });
    }
    if (frames->empty())
        diagnostics.add({arguments.reference, 0, 0}, "", "shares no frame with " + arguments.image);
    return frames;
}

const Plane* plane_of(const std::optional<PlanarImage>& image, const fs::path& file, const char* name,
                      Diagnostics& diagnostics) {
    if (!image) return nullptr;
    const Plane* plane = image->find(name);
    if (plane && plane->type != PlaneType::uint) return plane;
    diagnostics.add({file.string(), 0, 0}, name,
                    plane ? "the channel holds integers" : "there is no such channel");
    return nullptr;
}

bool in_border(size_t pixel, uint32_t width, uint32_t height, uint32_t border) {
    const size_t x = pixel % width, y = pixel / width;
    return x < border || y < border || x + border >= width || y + border >= height;
}

void check_size(const PlanarImage& image, const PlanarImage& reference, const fs::path& file,
                Diagnostics& diagnostics) {
    if (image.width == reference.width && image.height == reference.height) return;
    diagnostics.add({file.string(), 0, 0}, "",
                    fmt::format("{} x {} pixels, the reference has {} x {}", image.width, image.height,
                                reference.width, reference.height));
}

std::optional<MetricSums> compare_frame(const CompareArguments& arguments,
                                        const std::vector<fs::path>& images,
                                        const std::optional<PlanarImage>& mask, uint32_t frame,
                                        Diagnostics& diagnostics) {
    const fs::path truth_file = visibility_file(arguments.reference, frame);
    const auto truth = read_exr(truth_file, diagnostics);
    const Plane* visibility = plane_of(truth, truth_file, "Y", diagnostics);
    const Plane* receiver = plane_of(truth, truth_file, "receiver", diagnostics);
    if (!visibility || !receiver) return std::nullopt;
    if (mask) check_size(*mask, *truth, arguments.mask, diagnostics);

    std::vector<PlanarImage> kept(images.size());
    ComparedFrame compared{truth->width, truth->height, visibility->values, {}, {}};
    for (size_t i = 0; i < images.size(); ++i) {
        const fs::path file = visibility_file(images[i], frame);
        auto image = read_exr(file, diagnostics);
        if (!plane_of(image, file, "Y", diagnostics)) continue;
        check_size(*image, *truth, file, diagnostics);
        kept[i] = std::move(*image);
        compared.seeds.emplace_back(kept[i].find("Y")->values);
    }
    if (!diagnostics.empty()) return std::nullopt;
    std::vector<uint8_t> counted(visibility->values.size());
    for (size_t p = 0; p < counted.size(); ++p)
        counted[p] = receiver->values[p] > 0.5f && (!mask || mask->planes.front().values[p] > 0) &&
                     !in_border(p, truth->width, truth->height, arguments.border);
    compared.counted = counted;
    return measure(compared);
}

std::optional<Comparison> compare(const CompareArguments& arguments, Diagnostics& diagnostics) {
    std::vector<fs::path> images{arguments.image};
    images.insert(images.end(), arguments.also.begin(), arguments.also.end());
    const auto truth = read_reference_info(arguments.reference, diagnostics);
    const auto frames = choose_frames(arguments, images, diagnostics);
    std::optional<PlanarImage> mask;
    if (!arguments.mask.empty()) {
        mask = read_exr(arguments.mask, diagnostics);
        if (mask && (mask->planes.empty() || mask->planes.front().type == PlaneType::uint))
            diagnostics.add({arguments.mask, 0, 0}, "", "a mask needs a channel of floats");
    }
    if (!truth || !frames || !diagnostics.empty()) return std::nullopt;
    MetricSums sums;
    for (const uint32_t frame : *frames) {
        const auto of_frame = compare_frame(arguments, images, mask, frame, diagnostics);
        if (!of_frame) return std::nullopt;
        sums.add(*of_frame);
    }
    return Comparison{*frames, *truth, metrics_of(sums)};
}

OrderedJson or_null(const std::optional<double>& value) {
    return value ? OrderedJson(*value) : OrderedJson();
}

OrderedJson to_json(const CompareArguments& arguments, const Comparison& c) {
    const MaskMetrics& m = c.metrics;
    OrderedJson json = {{"image", arguments.image}, {"reference", arguments.reference}, {"frames", c.frames}};
    json["seeds"] = arguments.also.size() + 1;
    json["pixels"] = {
        {"receivers", m.receivers}, {"penumbra", m.penumbra}, {"lit", m.lit}, {"umbra", m.umbra}};
    json["eps"] = penumbra_eps;
    json["reference_rays"] = c.truth.rays ? OrderedJson(*c.truth.rays) : OrderedJson();
    json["rmse"] = {{"all", or_null(m.rmse_all)},
                    {"penumbra", or_null(m.rmse_penumbra)},
                    {"lit", or_null(m.rmse_lit)},
                    {"umbra", or_null(m.rmse_umbra)}};
    json["psnr_db"] = or_null(m.psnr_db);
    json["max_abs"] = or_null(m.max_abs);
    json["bias_max_9x9"] = nullptr;
    json["ssim"] = nullptr;
    json["flip"] = {{"mean", nullptr}, {"weighted_median", nullptr}, {"p95", nullptr}};
    json["relmse"] = nullptr;
    json["n_eff"] = {{"value", or_null(m.n_eff)},
                     {"penumbra_only", or_null(m.n_eff_penumbra)},
                     {"ci95", nullptr},
                     {"variance_part", or_null(m.n_variance)},
                     {"bias_part", or_null(m.n_bias)},
                     {"exact", c.truth.exact}};
    if (m.n_eff_ci95) json["n_eff"]["ci95"] = *m.n_eff_ci95;
    json["leak"] = or_null(m.leak);
    json["acne"] = or_null(m.acne);
    json["peter_panning_px"] = nullptr;
    json["misclassified"] = {{"eps", nullptr},       {"0.05", nullptr},         {"0.25", nullptr},
                             {"false_lit", nullptr}, {"false_shadow", nullptr}, {"me", nullptr},
                             {"recall", nullptr},    {"eta_ray", nullptr},      {"interval", nullptr}};
    json["flicker"] = {{"rms", nullptr}, {"p99", nullptr}};
    json["lag"] = {{"k90", nullptr}, {"lag_px", nullptr}, {"residual", nullptr}};
    json["nonfinite"] = m.nonfinite;
    return json;
}

std::string text_of(const std::optional<double>& value) {
    return value ? fmt::format("{:.5g}", *value) : "-";
}

void print_text(const CompareArguments& arguments, const Comparison& c) {
    const MaskMetrics& m = c.metrics;
    const std::string quality = c.truth.exact ? "exact" : fmt::format("{} rays", c.truth.rays.value_or(0));
    fmt::print("{} against {} ({}): {} frames, {} seeds\n", arguments.image, arguments.reference, quality,
               c.frames.size(), arguments.also.size() + 1);
    fmt::print("pixels   receivers {}  penumbra {}  lit {}  umbra {}\n", m.receivers, m.penumbra, m.lit,
               m.umbra);
    fmt::print("rmse     all {}  penumbra {}  lit {}  umbra {}   psnr {} dB   largest {}\n",
               text_of(m.rmse_all), text_of(m.rmse_penumbra), text_of(m.rmse_lit), text_of(m.rmse_umbra),
               text_of(m.psnr_db), text_of(m.max_abs));
    fmt::print("n_eff    {}  in the penumbra {}  variance {}  bias {}", text_of(m.n_eff),
               text_of(m.n_eff_penumbra), text_of(m.n_variance), text_of(m.n_bias));
    if (m.n_eff_ci95) fmt::print("  95 % {:.4g} .. {:.4g}", (*m.n_eff_ci95)[0], (*m.n_eff_ci95)[1]);
    fmt::print("\nleak {}  acne {}  not finite {}\n", text_of(m.leak), text_of(m.acne), m.nonfinite);
}

}  // namespace

int run_compare(const CompareArguments& arguments) {
    Diagnostics diagnostics;
    const auto comparison = compare(arguments, diagnostics);
    if (!comparison) {
        std::cerr << diagnostics.text();
        return exit_wrong;
    }
    if (arguments.json)
        std::cout << to_json(arguments, *comparison).dump(2) << "\n";
    else
        print_text(arguments, *comparison);
    return exit_good;
}

}  // namespace penumbra
