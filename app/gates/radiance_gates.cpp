// SPDX-License-Identifier: MIT
#include "app/gates/radiance_gates.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "app/outputs.h"
#include "app/radiance_truth.h"

namespace penumbra::gates {
namespace {

using Look = std::function<void(uint32_t frame, const PlanarImage& image)>;

// Shows all frames, for one seed after the other.
bool run(const RadianceBench& bench, const char* what, const Shot& shot, const Look& look) {
    SessionOptions options;
    options.size = shot.size;
    options.captures = {bench.signal};
    options.jitter = false;  // the truth is that of pixel centres
    options.pass_costs = false;
    const auto session = Session::open(bench.device, bench.nodes, bench.pipeline, shot, options,
                                       bench.diagnostics, bench.warnings);
    if (!session) return false;
    for (uint32_t seed = 1; seed <= bench.study.seeds; ++seed) {
        session->set_param("seed", seed);
        for (uint32_t frame = 0; frame < shot.frames; ++frame) {
            if (bench.told)
                bench.told(what,
                           ((seed - 1) * shot.frames + frame) / double(bench.study.seeds * shot.frames));
            session->run_frame(frame, frame == 0);
            look(frame, captured_image(*session, bench.signal));
        }
    }
    return true;
}

// The truth of some frames of a shot; empty after an error.
std::vector<PlanarImage> truths(const RadianceBench& bench, const Shot& shot,
                                const std::vector<uint32_t>& frames, uint32_t rays) {
    if (bench.told) bench.told("the truth", 0);
    const auto session =
        open_radiance_truth(bench.device, shot, bench.signal, bench.diagnostics, bench.warnings);
    std::vector<PlanarImage> out;
    if (!session) return out;
    for (const uint32_t frame : frames) out.push_back(radiance_truth(bench.device, *session, frame, rays));
    return out;
}

double mean_of(const PlanarImage& image, std::span<const float> receiver) {
    const RadiancePlanes planes = radiance_planes(image);
    double sum = 0, pixels = 0;
    for (size_t i = 0; i < receiver.size(); ++i) {
        if (!(receiver[i] > 0)) continue;
        for (const auto& plane : planes.rgb) sum += static_cast<double>(plane[i]);
        ++pixels;
    }
    return sum / (3 * pixels);
}

}  // namespace

std::optional<std::array<double, roughness_classes>> measure_furnace(const RadianceBench& bench) {
    const Shot shot = bench.scenes.furnace(bench.study.size, bench.study.furnace_frames);
    std::vector<uint32_t> frames;
    for (uint32_t frame = 0; frame < shot.frames; ++frame) frames.push_back(frame);
    constexpr uint32_t few_rays = 16;  // all find 1; what is asked for is which pixel shows what
    const std::vector<PlanarImage> truth = truths(bench, shot, frames, few_rays);
    std::array<double, roughness_classes> worst{};
    const auto look = [&](uint32_t frame, const PlanarImage& image) {
        const RadianceTruth known = known_of(truth[frame]);
        const RadiancePlanes planes = radiance_planes(image);
        for (size_t i = 0; i < known.receiver.size(); ++i) {
            if (!(known.receiver[i] > 0)) continue;
            double& off = worst[roughness_class(known.roughness[i])];
            for (const auto& plane : planes.rgb) {
                const double e = std::abs(static_cast<double>(plane[i]) - 1);
                off = std::isfinite(e) ? std::max(off, e) : INFINITY;
            }
        }
    };
    if (truth.empty() || !run(bench, "white furnace", shot, look)) return std::nullopt;
    return worst;
}

std::optional<std::vector<RadianceErrorSums>> measure_still(const RadianceBench& bench) {
    const RadianceStudy& study = bench.study;
    const Shot shot = bench.scenes.room(study.size, study.after.back(), false);
    const std::vector<PlanarImage> truth = truths(bench, shot, {0}, study.rays);
    std::vector<RadianceErrorSums> out(study.after.size());
    PlanarImage before;
    const auto look = [&](uint32_t frame, const PlanarImage& image) {
        const RadianceTruth known = known_of(truth.front());
        const auto place = std::ranges::find(study.after, frame + 1);
        if (place != study.after.end()) {
            const bool last = frame + 1 == study.after.back() && frame > 0;
            out[static_cast<size_t>(place - study.after.begin())].add(
                last ? radiance_errors(radiance_planes(image), known, radiance_planes(before), known.signal)
                     : radiance_errors(radiance_planes(image), known));
        }
        before = image;
    };
    if (truth.empty() || !run(bench, "standing still", shot, look)) return std::nullopt;
    return out;
}

std::optional<RadianceErrorSums> measure_moving(const RadianceBench& bench) {
    const Shot shot = bench.scenes.room(bench.study.size, bench.study.moving_frames, true);
    const std::vector<PlanarImage> truth = truths(bench, shot, {shot.frames - 1}, bench.study.rays);
    RadianceErrorSums out;
    const auto look = [&](uint32_t frame, const PlanarImage& image) {
        if (frame + 1 == shot.frames)
            out.add(radiance_errors(radiance_planes(image), known_of(truth.front())));
    };
    if (truth.empty() || !run(bench, "in motion", shot, look)) return std::nullopt;
    return out;
}

std::optional<std::vector<double>> measure_lamp_off(const RadianceBench& bench) {
    const RadianceStudy& study = bench.study;
    const Shot shot = bench.scenes.lamp_off(study.size);
    constexpr uint32_t few_rays = 16;
    const std::vector<PlanarImage> truth = truths(bench, shot, {last_off_frame}, few_rays);
    std::vector<double> means(shot.frames, 0);
    const auto look = [&](uint32_t frame, const PlanarImage& image) {
        means[frame] += mean_of(image, known_of(truth.front()).receiver);
    };
    if (truth.empty() || !run(bench, "lamp that goes off", shot, look)) return std::nullopt;
    std::vector<double> left;
    for (const uint32_t after : study.after_off)
        left.push_back((means[lamp_off_frame - 1 + after] - means.back()) /
                       (means[lamp_off_frame - 1] - means.back()));
    return left;
}

}  // namespace penumbra::gates
