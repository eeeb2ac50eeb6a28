// SPDX-License-Identifier: MIT
// Pipelines of reflections or indirect light on shots, beside brute force: all that a report of radiance
// says. In motion all stand ready at once and take turns frame by frame, in an order that rotates.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/report/shots.h"
#include "app/session.h"
#include "host/metrics/flip.h"
#include "host/metrics/front.h"
#include "host/metrics/radiance_error.h"

namespace penumbra::report {

struct RadianceStudy {
    std::array<uint32_t, 2> size{192, 108};
    uint32_t seeds = 2;    // of every run; of each frame that is timed the least time of all counts
    uint32_t rays = 1024;  // per pixel, of the truth
    std::vector<uint32_t> after{1, 9, 65};                      // frames that have been run, standing still
    uint32_t moving_frame = 16;                                 // of the shot as it is: judged
    uint32_t timed_from = 8;                                    // frames from there to that one are timed
    std::vector<uint32_t> brute_force{1, 2, 4, 8, 16, 32, 64};  // rays per pixel
};

struct RadianceContender {
    std::string id, file;
    std::optional<uint32_t> rays;       // of brute force
    std::vector<std::string> settings;  // --set
    CheckedPipeline pipeline;
};

// Pipelines that were named, then brute force of the numbers of rays that none of them has: raw_reflections
// or raw_indirect. Nothing, with diagnostics, where one does not make the signal.
std::optional<std::vector<RadianceContender>> radiance_contenders(
    const std::vector<std::string>& wanted, const std::string& signal, const RadianceStudy& study,
    const std::filesystem::path& root, const NodeSet& nodes, Diagnostics& diagnostics);

struct RadianceRow {
    std::string shot;
    size_t contender = 0;
    std::vector<RadianceErrorSums> still;  // parallel to RadianceStudy::after; the last one's has flicker
    RadianceErrorSums moving;
    std::optional<double> cost_ms;  // of the passes that the signal depends on: median over timed frames
    // Of the lit picture in which all but this signal is true, at the moving frame, under the first seed.
    FlipPool flip;
    double lit_relmse = 0;
    std::string image;  // that picture
};

struct RadianceResults {
    std::string command, signal, device;
    bool cpu = false;  // whether costs are process CPU time
    RadianceStudy study;
    std::vector<RadianceContender> contenders;
    std::vector<std::string> shots;
    std::vector<RadianceRow> rows;  // by shot, then by contender
};

// Cost and N_eff in motion; nothing where either is not known.
std::optional<FrontPoint> front_point(const RadianceRow& row);
// Its N_eff over that of brute force in the same time; nothing where a piece of the line is missing.
std::optional<Front::Reading> over_brute_force(const RadianceResults& results, const RadianceRow& row);

struct RadianceBench {
    Device& device;
    const NodeSet& nodes;
    std::filesystem::path folder;  // images go to its images/
    std::function<void()> step;    // work_of() times per shot
};
uint32_t work_of(const RadianceResults& results);  // steps of one shot

// Adds a row per contender; false, with diagnostics, where the shot or a plan is wrong.
bool measure_radiance(const RadianceBench& bench, const ReportShot& shot, RadianceResults& results,
                      Diagnostics& diagnostics, std::vector<std::string>& warnings);

}  // namespace penumbra::report
