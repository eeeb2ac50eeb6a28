// SPDX-License-Identifier: MIT
// penumbra report: measures all that compete and writes results.json, results.csv, tables.md and index.html,
// in this order and each under its name only when it is whole. An earlier index.html goes before anything is
// measured, so that a folder with one is a complete report.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/node_folders.h"
#include "app/progress.h"
#include "app/report/markdown_tables.h"
#include "app/report/measure.h"
#include "app/report/page.h"
#include "app/report/parts.h"
#include "app/report/radiance_report.h"
#include "app/text_file.h"
#include "app/wrong.h"
#include "host/gbuffer/gbuffer.h"
#include "host/json_dump.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using namespace report;

// Quick reports look at these of what is shipped: rendering cascades on a software device takes longer than
// all else.
constexpr const char* quick_shots[] = {"colonnade", "engine"};
constexpr const char* quick_pipelines[] = {"raw", "fidelityfx", "shadows"};
constexpr const char* quick_lamp_pipelines[] = {"light_raw", "light_sigma", "light_shadows"};

struct Job {
    fs::path folder;
    Results results;
    std::vector<ReportShot> shots;
    std::vector<EdgeShot> edges;
};

std::optional<Study> study_of(const ReportArguments& arguments) {
    Study study = arguments.quick ? quick_study() : arguments.front ? front_study() : Study{};
    if (!arguments.size.empty()) {
        const auto size = parse_size(arguments.size);
        if (!size) return std::nullopt;
        study.size = *size;
    }
    if (arguments.seeds) study.seeds = *arguments.seeds;
    if (arguments.rounds) study.rounds = *arguments.rounds;
    if (arguments.rays) study.rays = *arguments.rays;
    study.light = arguments.light;
    if (!study.light.empty()) study.edge_widths_px.clear();  // whose edges are the sun's
    return study;
}

std::vector<fs::path> shot_files(const ReportArguments& arguments, const fs::path& root,
                                 std::vector<LeftOut>& left_out, Diagnostics& diagnostics) {
    std::vector<std::string> wanted = arguments.shots;
    if (wanted.empty() && arguments.quick) wanted.assign(std::begin(quick_shots), std::end(quick_shots));
    std::vector<fs::path> files;
    for (const std::string& name : wanted)
        if (const auto file = shipped_file(name, root, shipped_shots, diagnostics)) files.push_back(*file);
    if (wanted.empty()) {
        for (const fs::path& file : shipped_files(root, shipped_shots)) {
            const auto shot = read_shot(file, diagnostics);
            if (shot && !shot->cuts.empty())
                left_out.push_back({file.generic_string(), "has cuts: nothing settles in it"});
            else
                files.push_back(file);
        }
    }
    if (files.empty() && diagnostics.empty())
        diagnostics.add({}, "--shots", "none given, and no folder of shipped ones is near the program");
    return files;
}

// Reads everything before anything is run, so that mistakes are found at once.
std::optional<Job> prepare(const ReportArguments& arguments, const NodeSet& nodes, Diagnostics& diagnostics) {
    const auto study = study_of(arguments);
    if (study && study->light == "sun")
        diagnostics.add({}, "--light", "names a lamp of the shots: leave it out for the sun's masks");
    if (!study || !diagnostics.empty()) return std::nullopt;
    const fs::path root = shipped_root();
    const bool of_lamp = !study->light.empty();
    std::vector<std::string> pipelines = arguments.pipelines;
    if (pipelines.empty() && arguments.quick)
        pipelines.assign(std::begin(of_lamp ? quick_lamp_pipelines : quick_pipelines),
                         std::end(of_lamp ? quick_lamp_pipelines : quick_pipelines));
    auto contenders = open_contenders(pipelines, root, nodes, diagnostics, arguments.front, of_lamp);
    std::vector<LeftOut> cut_shots;
    const std::vector<fs::path> files = shot_files(arguments, root, cut_shots, diagnostics);
    if (!contenders || !diagnostics.empty()) return std::nullopt;
    std::vector<std::string> pipeline_files;
    for (const Contender& contender : contenders->list) pipeline_files.push_back(contender.file);
    if (!can_be_reported(arguments.out, files, pipeline_files, arguments.node_folders, diagnostics))
        return std::nullopt;
    Job job;
    job.folder = arguments.out;
    for (const char* inside : {"images", "shots", "parts"}) fs::create_directories(job.folder / inside);
    const uint32_t still_frames = study->after_cut.empty() ? 0 : study->after_cut.back();
    for (const fs::path& file : files)
        if (auto shot = open_report_shot(file, job.folder / "shots", still_frames, diagnostics))
            if (!of_lamp || keep_light_alone(study->light, *shot, diagnostics))
                job.shots.push_back(std::move(*shot));
    for (const ReportShot& shot : job.shots)
        if (shot.moving.frames < study->moving_frames)
            diagnostics.add({shot.moving.file.string()}, "frames",
                            fmt::format("is {}: {} are measured", shot.moving.frames, study->moving_frames));
    for (const double width : study->edge_widths_px)
        for (const double speed : study->edge_speeds_px)
            job.edges.push_back(
                make_edge_shot(width, speed, study->edge_frame, job.folder / "shots", diagnostics));
    job.results.command = arguments.command_line;
    job.results.quick = arguments.quick;
    job.results.study = *study;
    job.results.contenders = std::move(contenders->list);
    job.results.left_out = std::move(contenders->left_out);
    std::ranges::move(cut_shots, std::back_inserter(job.results.left_out));
    if (!diagnostics.empty()) return std::nullopt;
    fs::remove(job.folder / "index.html");
    return job;
}

// Measures what no earlier run has left behind; every part is written as soon as it is whole.
class Measuring {
  public:
    Measuring(Job& job, Device& device, const NodeSet& nodes, const ReportArguments& arguments,
              Diagnostics& diagnostics, std::vector<std::string>& warnings)
        : job_(job),
          device_(device),
          nodes_(nodes),
          parts_(job.folder, job.results, arguments.node_folders),
          again_(arguments.again),
          diagnostics_(diagnostics),
          warnings_(warnings) {}

    bool all() {
        std::vector<Part> parts;
        for (const ReportShot& shot : job_.shots) {
            std::vector<Shot> shots{shot.moving};
            if (shot.still) shots.push_back(*shot.still);
            parts.push_back({parts_.name("shot." + shot.name, shots), work_of_shot(job_.results.study),
                             [&](const Bench& bench, Results& part) {
                                 return measure_shot(bench, shot, part, diagnostics_, warnings_);
                             }});
        }
        for (const EdgeShot& edge : job_.edges)
            parts.push_back(
                {edge_name(edge), work_of_edge(job_.results.study), [&](const Bench& bench, Results& part) {
                     return measure_edge(bench, edge, part, diagnostics_, warnings_);
                 }});
        uint64_t work = 0;
        for (const Part& part : parts)
            if (!kept(part)) work += part.work;
        Progress progress("report", work);
        for (size_t p = 0; p < parts.size(); ++p) {
            if (auto json = kept(parts[p])) {
                append(*json, job_.results);
                continue;
            }
            if (!measure(parts[p], progress)) return false;
            progress.note(fmt::format("{}: {} of {} parts", parts[p].name.name, p + 1, parts.size()));
        }
        return true;
    }

  private:
    struct Part {
        Parts::Name name;
        uint64_t work = 0;
        std::function<bool(const Bench&, Results&)> measure;
    };

    std::optional<nlohmann::ordered_json> kept(const Part& part) const {
        return again_ ? std::nullopt : parts_.find(part.name);
    }

    // What an edge's contenders share follows from the shots that were looked at.
    Parts::Name edge_name(const EdgeShot& edge) const {
        std::vector<Shot> shots{edge.shot};
        for (const ReportShot& shot : job_.shots) shots.push_back(shot.moving);
        return parts_.name(fmt::format("edge.{:g}px_{:+g}", edge.width_px, edge.speed_px), shots);
    }

    // The page is made of what was written, so that it is the same page when the part is used again.
    bool measure(const Part& part, Progress& progress) {
        parts_.forget(part.name);
        Results results = job_.results;
        const size_t shots = results.shots.size(), rows = results.rows.size(), edge = results.edge.size();
        const Bench bench{device_, nodes_, job_.folder, [&](uint64_t work) { progress.step(work); },
                          [&](const std::string& text) { progress.say(text); }};
        if (!part.measure(bench, results)) return false;
        nlohmann::ordered_json json = to_json(results);
        const auto only_new = [&](const char* list, size_t old) {
            json[list].erase(json[list].begin(), json[list].begin() + static_cast<std::ptrdiff_t>(old));
        };
        only_new("shots", shots);
        only_new("results", rows);
        only_new("edge", edge);
        parts_.keep(part.name, json);
        append(json, job_.results);
        return true;
    }

    Job& job_;
    Device& device_;
    const NodeSet& nodes_;
    Parts parts_;
    bool again_;
    Diagnostics& diagnostics_;
    std::vector<std::string>& warnings_;
};

// Contenders as they would run by themselves on the first shot: without captures, with the smallest heap
// looked for.
std::optional<std::vector<PipelinePlan>> plan_contenders(const Job& job, const Device& device,
                                                         const Facts& facts, Diagnostics& diagnostics) {
    DeviceTable table = device_table(handles_of(device));
    table.features = features_of(device);
    std::vector<PipelinePlan> plans;
    Doing doing;
    for (size_t c = 0; c < job.results.contenders.size(); ++c) {
        const Contender& contender = job.results.contenders[c];
        CompileOptions options;
        if (!contender.variant()) options.optimum_search_nodes = report_search_nodes;
        options.optimum_progress = [&](double share) {
            doing("looking for the smallest possible heap of " + contender.id + ", which may be found sooner",
                  share);
        };
        const Target target = standalone_target(contender.pipeline, table, job.results.study.size, facts);
        auto plan = compile(contender.pipeline, target, options, diagnostics);
        if (!plan) return std::nullopt;
        plans.push_back({c, std::move(*plan)});
    }
    return plans;
}

// What all contenders take that stand ready at once, each with a host of its own, and the masks that are
// kept.
std::string memory_text(const Job& job, const std::vector<PipelinePlan>& plans) {
    const uint64_t host_bytes = gbuffer_bytes_per_pixel();
    const Study& study = job.results.study;
    const uint64_t pixels = uint64_t{study.size[0]} * study.size[1];
    const uint64_t masks =
        (study.motion_frames +
         std::max<uint64_t>(study.moving_frames / study.moving_every, study.after_cut.size()) * study.seeds) *
        plans.size() * sizeof(float);
    uint64_t bytes = pixels * (masks + host_bytes * plans.size());
    for (const PipelinePlan& planned : plans) bytes += planned.plan.memory.heap_bytes;
    return fmt::format(
        "{} contenders at {}x{}: about {:.1f} GiB of memory beside the scenes, of {:.1f} that this "
        "machine has",
        plans.size(), study.size[0], study.size[1], static_cast<double>(bytes) / (1 << 30),
        static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE)) /
            (1 << 30));
}

}  // namespace

int run_report(const ReportArguments& arguments) {
    if (!light_fits(arguments.signal, arguments.light)) return exit_wrong;
    if (arguments.signal != "visibility") return run_radiance_report(arguments);
    const auto nodes = open_nodes(arguments.node_folders);
    if (!nodes) return exit_wrong;
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    auto job = prepare(arguments, *nodes, diagnostics);
    if (!job) return wrong(diagnostics);
    Device device({arguments.device, false});
    job->results.device = device.info();
    Shot first = job->shots.front().moving;
    first.size = job->results.study.size;
    auto scene = load_scene(first, diagnostics, warnings);
    std::optional<std::vector<PipelinePlan>> plans;
    if (scene) {
        StandaloneOptions options{first.size, 1, false};
        if (!job->results.study.light.empty()) options.light = job->results.study.light;
        const StandaloneHost host(device, first, std::move(*scene), options);
        plans = plan_contenders(*job, device, host.facts(), diagnostics);
    }
    bool measured = false;
    if (plans) {
        std::cerr << memory_text(*job, *plans) << "\n";
        measured = Measuring(*job, device, *nodes, arguments, diagnostics, warnings).all();
    }
    print_warnings(warnings);
    if (!measured) return wrong(diagnostics);
    std::erase_if(*plans,
                  [&](const PipelinePlan& p) { return job->results.contenders[p.contender].variant(); });
    write_text(job->folder / "results.json", json_dump(to_json(job->results), 2) + "\n");
    write_text(job->folder / "results.csv", to_csv(job->results));
    write_text(job->folder / "tables.md", markdown_tables(job->results));
    write_text(job->folder / "index.html", report_page(job->results, *plans, job->folder));
    fmt::print("{}\n", (job->folder / "index.html").string());
    return exit_good;
}

}  // namespace penumbra
