// SPDX-License-Identifier: MIT
// Everything a report has measured, as data; results.json and results.csv are this and nothing else.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "app/report/contenders.h"
#include "app/report/runner.h"
#include "app/report/statistics.h"
#include "app/report/study.h"
#include "host/device/device.h"
#include "host/metrics/metrics.h"

namespace penumbra::report {

// The error at one frame, over all seeds.
struct Judged {
    uint32_t frame = 0;  // of the shot; after a cut: frames since then, from 1
    MaskMetrics metrics;
};

struct PassFigure {
    PassName pass;
    std::optional<Estimate> ms, cpu_ms;
};

// One contender on one shot: a row of the tables, a point of the plots.
struct Row {
    size_t shot = 0, contender = 0;
    // The contender with fewer passes, or an earlier one, whose masks are this one's to the bit in all judged
    // frames of both runs under the first seed; the figures of the masks are then its.
    std::optional<size_t> same_as;
    // Of the passes that the mask depends on, and of all passes, in the moving shot; `cost` is process CPU
    // time on a CPU device, else GPU time: the figure to trust.
    std::optional<Estimate> mask_ms, frame_ms, mask_cpu_ms, frame_cpu_ms;
    std::vector<PassFigure> passes;
    std::optional<Estimate> maps_cpu_ms;   // of drawing shadow maps, where any are read; not in the others
    std::optional<double> rays_per_pixel;  // mean, where passes count rays
    // Of the moving shot, pooled over the judged frames from Study::settling on.
    MaskMetrics moving;
    std::optional<double> ssim;      // near the penumbra
    std::optional<double> bias_9x9;  // the largest of any frame
    // Of the lit picture at ShotFacts::image_frame under the first seed.
    std::optional<FlipPool> flip;
    std::optional<double> relmse;
    std::optional<double> flicker;  // rms change between the last two frames of the still shot
    std::vector<Judged> after_cut, over_time;
    std::vector<std::string> images;  // files, relative to the report's folder: mask, error

    const std::optional<Estimate>& mask_cost(bool cpu) const { return cpu ? mask_cpu_ms : mask_ms; }
    const MaskMetrics* after(uint32_t frames) const;  // a cut; null where that was not judged
};

struct ShotFacts {
    std::string name, file, still_file;
    bool exact = false;  // the truth is a closed form
    std::array<uint32_t, 2> size{};
    uint64_t receivers = 0, penumbra = 0;  // pixels of the last judged frame
    uint32_t image_frame = 0;              // which the images show
    std::string reference_image;
    std::string motion_image;  // the last Study::motion_frames frames, of shown_in_motion(); none: empty
    std::string measured;      // when: "2026-01-31 12:00 UTC"
};

// N_eff behind a straight edge that moves.
struct EdgePoint {
    double width_px = 0, speed_px = 0;
    size_t contender = 0;
    MaskMetrics metrics;
    std::optional<double> lag_px;  // behind the true edge, across it
};

struct Results {
    std::string command;
    bool quick = false;
    Study study;
    DeviceInfo device;
    std::vector<Contender> contenders;
    std::vector<LeftOut> left_out;
    std::vector<ShotFacts> shots;
    std::vector<Row> rows;  // by shot, then by contender
    std::vector<EdgePoint> edge;

    const Row* row(size_t shot, size_t contender) const;
    // The contender whose masks are this one's to the bit in every shot, and this one where there is none.
    size_t original(size_t contender) const;
    // The worst speed of a contender at a width; the resting edge is no speed.
    const EdgePoint* worst_edge(size_t contender, double width_px) const;
    const EdgePoint* resting_edge(size_t contender, double width_px) const;
    // "+0.25", or "any" where all speeds are as bad.
    std::string speed_of(const EdgePoint& worst) const;
};

// Unknown values are null, never absent.
nlohmann::ordered_json to_json(const Results& results);
// Adds the shots, rows and edges of what to_json() has made of results with the same contenders. Infinities
// have become unknown. Throws nlohmann::json::exception, and adds nothing, where the JSON is anything else.
void append(const nlohmann::ordered_json& json, Results& results);
std::string to_csv(const Results& results);
// As one field of a CSV file (RFC 4180).
std::string csv_field(const std::string& text);

}  // namespace penumbra::report
