// SPDX-License-Identifier: MIT
// penumbra bench: what pipelines cost, pass by pass, in units that carry over to other machines
// (docs/performance.md).
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/bench/bench_text.h"
#include "app/commands.h"
#include "app/frame_range.h"
#include "app/node_folders.h"
#include "app/pipeline_file.h"
#include "app/progress.h"
#include "app/report/contenders.h"
#include "app/view_source.h"
#include "app/wrong.h"
#include "host/json_dump.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

struct Job {
    bench::Bench bench;
    std::vector<bench::Subject> subjects;
    std::vector<std::array<uint32_t, 2>> sizes;
};

// Two files of one name are told apart by their paths.
void make_unique(std::vector<bench::Contender>& contenders) {
    for (bench::Contender& c : contenders)
        if (std::ranges::count(contenders, c.id, &bench::Contender::id) > 1) c.id = c.file;
}

std::vector<CheckedPipeline> for_lights(const std::vector<Pipeline>& pipelines, const Shot& shot,
                                        const std::string& light, const NodeSet& nodes,
                                        Diagnostics& diagnostics) {
    std::vector<CheckedPipeline> checked;
    for (Pipeline pipeline : pipelines) {
        const size_t before = diagnostics.size();
        name_lights(pipeline, shot, light, diagnostics);
        auto c = diagnostics.size() == before ? check(pipeline, nodes, diagnostics) : std::nullopt;
        if (c) checked.push_back(std::move(*c));
    }
    return checked;
}

bench::Subject subject_of(Shot shot, const std::vector<Pipeline>& pipelines, const std::string& light,
                          const NodeSet& nodes, Diagnostics& diagnostics) {
    bench::Subject subject;
    subject.pipelines = for_lights(pipelines, shot, light, nodes, diagnostics);
    if (light.empty() && shot.lights.size() > 1) {
        subject.fewer = shot;
        subject.fewer->lights.erase(std::prev(shot.lights.end())->first);
        Diagnostics named;  // a pipeline that names its lights is for these alone
        subject.for_fewer = for_lights(pipelines, *subject.fewer, {}, nodes, named);
        if (!named.empty()) subject.fewer.reset();
    }
    subject.shot = std::move(shot);
    return subject;
}

// Reads everything before anything is run, so that mistakes are found at once.
std::optional<Job> prepare(const BenchArguments& arguments, const NodeSet& nodes, Diagnostics& diagnostics) {
    Job job;
    job.bench.command = arguments.command_line;
    job.bench.options.still = arguments.still;
    job.bench.options.still_camera = arguments.still_camera;
    job.bench.options.rounds = arguments.rounds;
    job.bench.options.light = arguments.light;
    const auto frames = parse_frames(arguments.frames, diagnostics);
    if (!frames) return std::nullopt;
    if ((*frames)[0] == (*frames)[1] && arguments.rounds == 1) {
        diagnostics.add({"--frames"}, "",
                        "a frame is timed pass by pass or as a whole, by turns: two frames, or --rounds 2");
        return std::nullopt;
    }
    job.bench.options.frames = *frames;
    for (const std::string& text : arguments.sizes) {
        const auto size = parse_size(text, "--sizes");
        if (!size) return std::nullopt;
        job.sizes.push_back(*size);
    }
    const fs::path root = shipped_root();
    std::vector<Pipeline> pipelines;
    for (const std::string& name : arguments.pipelines) {
        const auto file = shipped_file(name, root, shipped_pipelines, diagnostics);
        auto pipeline = file ? load_pipeline(*file, arguments.settings, diagnostics) : std::nullopt;
        if (!pipeline || !check(*pipeline, nodes, diagnostics)) continue;
        job.bench.contenders.push_back({file->stem().string(), file->generic_string()});
        pipelines.push_back(std::move(*pipeline));
    }
    make_unique(job.bench.contenders);
    for (const std::string& name : arguments.shots)
        if (const auto file = shipped_file(name, root, shipped_shots, diagnostics))
            if (auto shot = read_completed_shot(*file, diagnostics)) {
                if (!arguments.still && job.bench.options.frames[1] >= shot->frames)
                    diagnostics.add({file->string()}, "--frames",
                                    fmt::format("the shot has {} frames", shot->frames));
                job.subjects.push_back(subject_of(arguments.still ? bench::standing_still(std::move(*shot))
                                                  : arguments.still_camera
                                                      ? bench::with_still_camera(std::move(*shot))
                                                      : std::move(*shot),
                                                  pipelines, arguments.light, nodes, diagnostics));
            }
    return diagnostics.empty() ? std::optional(std::move(job)) : std::nullopt;
}

bool measure_all(Job& job, Device& device, const NodeSet& nodes, Diagnostics& diagnostics,
                 std::vector<std::string>& warnings) {
    const bench::Options& options = job.bench.options;
    Progress progress("bench", uint64_t{job.subjects.size()} * job.sizes.size() *
                                   job.bench.contenders.size() * options.rounds * (options.frames[1] + 1));
    for (const auto& size : job.sizes)
        for (const bench::Subject& subject : job.subjects) {
            auto scene = bench::measure(
                device, nodes, subject, size, options, [&] { progress.step(); }, diagnostics, warnings);
            if (!scene) return false;
            job.bench.scenes.push_back(std::move(*scene));
            progress.note(fmt::format("{} at {}x{}", subject.shot.name, size[0], size[1]));
        }
    return true;
}

}  // namespace

int run_bench(const BenchArguments& arguments) {
    const auto nodes = open_nodes(arguments.node_folders);
    if (!nodes) return exit_wrong;
    Diagnostics diagnostics;
    auto job = prepare(arguments, *nodes, diagnostics);
    if (!job) return wrong(diagnostics);
    Device device({arguments.device, false});
    job->bench.device = device.info();
    std::vector<std::string> warnings;
    const bool measured = measure_all(*job, device, *nodes, diagnostics, warnings);
    print_warnings(warnings);
    if (!measured) return wrong(diagnostics);
    if (arguments.format == "json")
        fmt::print("{}\n", json_dump(bench::to_json(job->bench), 2));
    else
        fmt::print("{}", bench::tables(job->bench));
    return exit_good;
}

}  // namespace penumbra
