// SPDX-License-Identifier: MIT
// penumbra report --signal: measures all that compete and writes results.json, tables.md and index.html,
// whose earlier one goes before anything is measured, so that a folder with one is a complete report.
#include "app/report/radiance_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/node_folders.h"
#include "app/progress.h"
#include "app/report/radiance_page.h"
#include "app/shipped_files.h"
#include "app/text_file.h"
#include "app/wrong.h"
#include "host/json_dump.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using namespace report;

struct Job {
    fs::path folder;
    RadianceResults results;
    std::vector<ReportShot> shots;
};

std::optional<RadianceStudy> study_of(const ReportArguments& arguments) {
    RadianceStudy study;
    if (arguments.quick) {
        study.size = {128, 72};
        study.rays = 256;
        study.after = {1, 9};
        study.brute_force = {1, 4, 16, 64};
    }
    if (!arguments.size.empty()) {
        const auto size = parse_size(arguments.size);
        if (!size) return std::nullopt;
        study.size = *size;
    }
    study.seeds = arguments.seeds.value_or(study.seeds);
    study.rays = arguments.rays.value_or(study.rays);
    return study;
}

// Names of shots: also those in scenes/radiance.
std::string radiance_shot(const std::string& wanted, const fs::path& root) {
    const fs::path there = root / "scenes/radiance" / (wanted + ".shot.json");
    std::error_code none;
    return fs::exists(there, none) ? there.string() : wanted;
}

std::optional<Job> prepare(const ReportArguments& arguments, const NodeSet& nodes, Diagnostics& diagnostics) {
    for (const auto& [given, option] :
         {std::pair{arguments.front, "--front"}, std::pair{arguments.again, "--again"},
          std::pair{arguments.rounds.has_value(), "--rounds"}})
        if (given) diagnostics.add({}, option, "is of visibility, not of radiance");
    const auto study = study_of(arguments);
    if (!study || !diagnostics.empty()) return std::nullopt;
    const fs::path root = shipped_root();
    Job job;
    job.folder = arguments.out;
    job.results.command = arguments.command_line;
    job.results.signal = arguments.signal;
    job.results.study = *study;
    std::vector<std::string> pipelines = arguments.pipelines, shots = arguments.shots;
    if (pipelines.empty() && arguments.signal == "specular")
        pipelines = {"fidelityfx_reflections", "relax", "reflections"};
    if (pipelines.empty()) pipelines = {"relax_indirect", "indirect"};
    if (shots.empty()) shots = {"polished"};
    if (arguments.shots.empty() && !arguments.quick) shots = {"polished", "chrome", "street"};
    auto contenders = radiance_contenders(pipelines, arguments.signal, *study, root, nodes, diagnostics);
    if (!contenders) return std::nullopt;
    FileList files;
    for (const std::string& name : shots)
        if (const auto file = shipped_file(radiance_shot(name, root), root, shipped_shots, diagnostics))
            files.push_back(*file);
    std::vector<std::string> pipeline_files;
    for (const RadianceContender& contender : *contenders) pipeline_files.push_back(contender.file);
    if (!can_be_reported(job.folder, files, pipeline_files, arguments.node_folders, diagnostics) ||
        !diagnostics.empty())
        return std::nullopt;
    job.results.contenders = std::move(*contenders);
    for (const char* inside : {"images", "shots"}) fs::create_directories(job.folder / inside);
    for (const fs::path& file : files)
        if (auto shot = open_report_shot(file, job.folder / "shots", study->after.back(), diagnostics))
            job.shots.push_back(std::move(*shot));
    for (const ReportShot& shot : job.shots)
        if (shot.moving.frames <= study->moving_frame)
            diagnostics.add(
                {shot.moving.file.string()}, "frames",
                fmt::format("is {}: frame {} is measured", shot.moving.frames, study->moving_frame));
    if (!diagnostics.empty()) return std::nullopt;
    fs::remove(job.folder / "index.html");
    return job;
}

}  // namespace

int run_radiance_report(const ReportArguments& arguments) {
    const auto nodes = open_nodes(arguments.node_folders);
    if (!nodes) return exit_wrong;
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    auto job = prepare(arguments, *nodes, diagnostics);
    if (!job) return wrong(diagnostics);
    Device device({arguments.device, false});
    job->results.device = device.info().name;
    job->results.cpu = device.info().is_cpu;
    bool good = true;
    {
        Progress progress("report", job->shots.size() * uint64_t{work_of(job->results)});
        for (const ReportShot& shot : job->shots)
            good = good && measure_radiance({device, *nodes, job->folder, [&] { progress.step(); }}, shot,
                                            job->results, diagnostics, warnings);
    }
    print_warnings(warnings);
    if (!good) return wrong(diagnostics);
    write_text(job->folder / "results.json", json_dump(to_json(job->results), 2) + "\n");
    write_text(job->folder / "tables.md", markdown_tables(job->results));
    write_text(job->folder / "index.html", radiance_page(job->results, job->folder));
    fmt::print("{}\n", (job->folder / "index.html").string());
    return exit_good;
}

}  // namespace penumbra
