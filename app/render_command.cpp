// SPDX-License-Identifier: MIT
// penumbra render: executes a pipeline on a shot frame by frame and writes outputs and captures. report.json
// comes last, so that a folder with a report is a complete one.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <set>

#include "app/commands.h"
#include "app/counted.h"
#include "app/fact_list.h"
#include "app/frame_range.h"
#include "app/input_files.h"
#include "app/made_up_shot.h"
#include "app/node_folders.h"
#include "app/outputs.h"
#include "app/pipeline_file.h"
#include "app/progress.h"
#include "app/report.h"
#include "app/session.h"
#include "app/text_file.h"
#include "app/validation.h"
#include "app/view_source.h"
#include "app/wrong.h"
#include "host/json_dump.h"
#include "host/shots/model_shot.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

struct Job {
    CheckedPipeline pipeline;
    Shot shot;
    MadeUpShot made_up;
    std::string camera;  // of the model, where the shot is made up
    fs::path folder;
    FileList read;
    WrittenFrames earlier;  // in the folder, and none of this run's unless it writes them
    std::array<uint32_t, 2> size{};
    FrameRange frames{};
    Facts facts;
    std::vector<std::string> graph_captures, host_captures;
};

std::optional<Job> prepare(const RenderArguments& arguments, const NodeSet& nodes) {
    Diagnostics diagnostics;
    const auto given = sort_files(arguments.files, arguments.view, diagnostics);
    if (!given) {
        std::cerr << diagnostics.text();
        return std::nullopt;
    }
    const fs::path folder =
        arguments.out.empty() ? fs::path("out") / view_name(given->view) : fs::path(arguments.out);
    auto view = open_view(given->view, folder, diagnostics);
    if (!view) std::cerr << diagnostics.text();
    const Shot* const of = view ? &view->shot : nullptr;
    auto pipeline = open_pipeline(pipeline_for(*given, of), arguments.settings, nodes, of, arguments.light);
    if (!pipeline || !view) return std::nullopt;
    const Shot& shot = view->shot;
    const MadeUpShot made_up{shot.file, view->made_up};
    const bool nobody_wrote = !made_up.text.empty();
    if (arguments.cascade_size && !pipeline->input("cascade_maps") && !pipeline->input("cascade_bounds")) {
        fmt::print(stderr, "--cascade-size: {} reads no shadow maps\n", pipeline->name);
        return std::nullopt;
    }
    FileList written{folder / "report.json"};
    if (nobody_wrote) written.push_back(shot.file);
    // Who asks for some frames alone may want them beside those that are there.
    const bool all = arguments.frames.empty() && arguments.every == 1;
    WrittenFrames earlier = all ? frames_of_report(folder) : WrittenFrames{};
    FileList read = files_of_shot(shot, nobody_wrote);
    for (const FileList& more :
         {files_of_pipelines({pipeline->file}), files_of_nodes(arguments.node_folders)})
        read.insert(read.end(), more.begin(), more.end());
    if (!spares(written, {read}, diagnostics) || !made_up.may_be_written(diagnostics)) {
        std::cerr << diagnostics.text();
        return std::nullopt;
    }
    const auto size = arguments.size.empty() ? std::optional(shot.size) : parse_size(arguments.size);
    auto frames = parse_frames(arguments.frames, shot.frames);
    const auto facts = parse_facts(arguments.facts, *nodes.domain());
    if (!size || !frames || !facts) return std::nullopt;
    // A model that stands still is one picture, which the frames before it only make smooth.
    if (nobody_wrote && arguments.frames.empty() && !moves(shot) && shot.animation.empty())
        (*frames)[0] = (*frames)[1];
    Job job{std::move(*pipeline),
            std::move(view->shot),
            made_up,
            view->camera,
            folder,
            std::move(read),
            std::move(earlier),
            *size,
            *frames,
            *facts,
            {},
            {}};
    job.graph_captures = job.pipeline.output_names();
    for (const std::string& name : arguments.captures) {
        const bool of_host = is_host_image(job.pipeline, name);
        if (!of_host && !job.pipeline.resource(name)) {
            std::vector<std::string> known(host_image_names().begin(), host_image_names().end());
            for (const CheckedResource& resource : job.pipeline.resources) known.push_back(resource.name);
            fmt::print(stderr, "--capture: {} has no \"{}\"{}\n", job.pipeline.name, name,
                       did_you_mean(name, known));
            return std::nullopt;
        }
        auto& list = of_host ? job.host_captures : job.graph_captures;
        if (std::find(list.begin(), list.end(), name) == list.end()) list.push_back(name);
    }
    return job;
}

// Of a model whose lamps this pipeline knows nothing of: nobody would miss them in the picture of the sun.
std::string lamps_left_out(const Session& session, const std::vector<std::string>& lamps) {
    const auto takes = [](const HostSlot& slot) { return slot.name.starts_with("light"); };
    if (lamps.empty() || std::ranges::any_of(session.plan().slots, takes)) return "";
    const size_t named = std::min<size_t>(lamps.size(), 5), unnamed = lamps.size() - named;
    return fmt::format("{}: the light of \"{}\"{} is left out; `lights` draws it, and `lit` beside the sun's",
                       session.plan().pipeline, fmt::join(lamps.begin(), lamps.begin() + named, "\", \""),
                       unnamed ? fmt::format(" and {} more", unnamed) : "");
}

bool shows_something(Device& device, const Session& session) {
    const std::vector<float> depth = host_image(device, session, "depth").planes.front().values;
    return std::ranges::any_of(depth, [](float metres) { return metres > 0; });
}

// With the likely reason. What is framed is in the picture, unless it is drawn nowhere.
std::string nothing_shown(const Scene& scene, const Job& job) {
    std::string why;
    if (!job.camera.empty()) why = fmt::format("; it is seen by the model's own camera, \"{}\"", job.camera);
    if (scene.has_translucent()) why += "; what lets light through is not drawn";
    if (why.empty() && !job.made_up.text.empty())
        why = "; it is too small or too thin, or its single-sided triangles are seen from behind";
    return "the picture shows nothing of the scene" + why;
}

// What an earlier run has left would pass for frames of this one. Only images of what this run writes, too;
// what has been written since, or was read, stays.
void remove_earlier(const Job& job, const OutputWriter& outputs) {
    std::set<fs::path> frames, images;
    for (const WrittenOutput& output : outputs.written()) {
        const fs::path frame = fs::path(output.file).stem();
        frames.insert(frame);
        images.insert(frame.stem());
    }
    size_t removed = 0;
    for (const auto& [file, time] : job.earlier) {
        if (frames.contains(file.stem()) || !images.contains(file.stem().stem())) continue;
        std::error_code failure;
        const auto is_it = [&](const fs::path& other) { return fs::equivalent(file, other, failure); };
        if (std::ranges::any_of(job.read, is_it)) continue;
        if (fs::last_write_time(file, failure) == time) removed += fs::remove(file, failure);
    }
    if (removed)
        fmt::print("  {} of an earlier run removed, of frames that this one has not\n",
                   counted(removed, "file"));
}

bool is_written(const Job& job, uint32_t frame, uint32_t every) {
    return frame >= job.frames[0] && (frame - job.frames[0]) % every == 0;
}

// Of the images that this run writes those that are there already. The folder is gone through, since there
// may be far more frames than files.
FileList images_there(const Session& session, const Job& job, uint32_t every) {
    std::set<std::string> stems;
    for (const auto* captures : {&job.graph_captures, &job.host_captures})
        for (const std::string& name : *captures)
            for (uint32_t frame = job.frames[0]; frame <= job.frames[1]; ++frame)
                if (is_written(job, frame, every))
                    for (std::string& stem : OutputWriter::names(session, name, frame))
                        stems.insert(std::move(stem));
    FileList there;
    std::error_code failure;
    for (fs::directory_iterator entry(job.folder, failure), end; !failure && entry != end;
         entry.increment(failure)) {
        const fs::path& file = entry->path();
        const bool image = file.extension() == ".exr" || file.extension() == ".png";
        if (image && stems.contains(file.stem().string())) there.push_back(file);
    }
    return there;
}

int render(const RenderArguments& arguments, Job job, const NodeSet& nodes) {
    const fs::path shot_file = job.shot.file;
    Device device({arguments.device, arguments.validate});
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    SessionOptions options;
    options.size = job.size;
    options.captures = job.graph_captures;
    options.seed = arguments.seed;
    options.light = arguments.light;
    if (arguments.cascade_size) options.cascade_size = *arguments.cascade_size;
    options.alias = !arguments.no_alias;
    if (arguments.no_jitter) options.jitter = false;
    options.validate = arguments.validate;
    options.facts = job.facts;
    std::vector<std::string> lamps;
    for (const auto& [name, lamp] : job.shot.lights)
        if (!job.made_up.text.empty()) lamps.push_back(name);
    Doing doing;
    options.doing = [&](const char* what, double share) { doing(what, share); };
    const auto session =
        Session::open(device, nodes, job.pipeline, std::move(job.shot), options, diagnostics, warnings);
    doing.clear();
    print_warnings(warnings);
    if (!session || !spares(images_there(*session, job, arguments.every), {job.read}, diagnostics))
        return wrong(diagnostics);
    if (const std::string left = lamps_left_out(*session, lamps); !left.empty()) print_warning(left);
    const fs::path& folder = job.folder;
    fs::create_directories(folder);
    fs::remove(folder / "report.json");
    job.made_up.write();

    OutputWriter outputs(device, folder);
    RenderedFrames rendered{job.frames, arguments.cold ? job.frames[0] : 0, {}};
    std::vector<Finding> findings = no_findings(session->plan());
    bool empty = true;
    const uint32_t start = rendered.start;
    {
        Progress progress(session->plan().pipeline, job.frames[1] - start + 1);
        for (uint32_t frame = start; frame <= job.frames[1]; ++frame) {
            rendered.costs.push_back(session->run_frame(frame, frame == start));
            add_frame(findings, frame, rendered.costs.back().passes);
            if (is_written(job, frame, arguments.every)) {
                empty = empty && !shows_something(device, *session);
                for (const std::string& name : job.graph_captures) outputs.write(*session, name, frame);
                for (const std::string& name : job.host_captures) outputs.write(*session, name, frame);
            }
            progress.step();
        }
    }
    for (const std::string& message : device.messages()) std::cerr << message << "\n";
    if (empty) {
        warnings.push_back(nothing_shown(session->host().scene(), job));
        print_warnings({&warnings.back(), 1});
    }
    const std::string complaints = complaint(findings);
    std::cerr << complaints;
    const auto report = render_report(arguments, *session, job.pipeline, device.info(), rendered, findings,
                                      outputs, warnings, seen_from(shot_file, folder));
    write_text(folder / "report.json", json_dump(report, 2) + "\n");
    print_summary(report);
    fmt::print("  written to {}/\n", folder.generic_string());
    if (device.message_count() != 0 || !complaints.empty()) return exit_failed;
    remove_earlier(job, outputs);
    return exit_good;
}

}  // namespace

int run_render(const RenderArguments& arguments) {
    const auto nodes = open_nodes(arguments.node_folders);
    auto job = nodes ? prepare(arguments, *nodes) : std::nullopt;
    return job ? render(arguments, std::move(*job), *nodes) : exit_wrong;
}

}  // namespace penumbra
