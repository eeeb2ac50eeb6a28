// SPDX-License-Identifier: MIT
// penumbra reference: the true visibility of a shot's frames, each frozen in time. Analytic scenes have it in
// closed form; elsewhere rays are counted.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <iostream>

#include "app/commands.h"
#include "app/frame_range.h"
#include "app/input_files.h"
#include "app/light_truth.h"
#include "app/made_up_shot.h"
#include "app/mask_folder.h"
#include "app/outputs.h"
#include "app/progress.h"
#include "app/radiance_truth.h"
#include "app/truth.h"
#include "app/view_source.h"
#include "app/wrong.h"
#include "host/truth/analytic.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

// The colour in a file of its own, as `render` writes it, with the receivers.
void write_colored_truth(const fs::path& folder, const Shot& shot, uint32_t frame, const Truth& truth) {
    PlanarImage image{shot.size[0], shot.size[1], {}};
    for (size_t c = 0; c < 3; ++c)
        image.planes.push_back({std::string(1, "RGB"[c]), PlaneType::real, truth.transmittance[c], {}});
    image.planes.push_back({"visibility", PlaneType::real, truth.visibility, {}});
    image.planes.push_back({"receiver", PlaneType::real, truth.receiver, {}});
    const fs::path file = folder / fmt::format("transmittance.{:04}.exr", frame);
    std::vector<float> rgb;
    for (size_t p = 0; p < truth.receiver.size(); ++p)
        for (const std::vector<float>& channel : truth.transmittance) rgb.push_back(channel[p]);
    write_exr(file, image);
    write_png_color(fs::path(file).replace_extension(".png"), image.width, image.height, rgb);
}

void write_truth(const fs::path& folder, const Shot& shot, uint32_t frame, Truth truth) {
    if (!truth.transmittance[0].empty()) write_colored_truth(folder, shot, frame, truth);
    PlanarImage image{shot.size[0], shot.size[1], {}};
    image.planes.push_back({"Y", PlaneType::real, std::move(truth.visibility), {}});
    image.planes.push_back({"receiver", PlaneType::real, std::move(truth.receiver), {}});
    image.planes.push_back({"rays", PlaneType::real, std::move(truth.rays), {}});
    write_exr(visibility_file(folder, frame), image);
    write_png_linear(fs::path(visibility_file(folder, frame)).replace_extension(".png"), image.width,
                     image.height, image.planes[0].values);
}

struct Job {
    Shot shot;
    MadeUpShot made_up;
    std::vector<uint32_t> frames;
    std::string light;  // as asked for, else as it was rendered
    bool jitter = false;
};

// Lights that have masks of their own in a folder.
std::vector<std::string> lights_with_masks(const FramesByImage& images, const Shot& shot) {
    std::vector<std::string> lights;
    for (const auto& [light, about] : shot.lights)
        if (images.contains("visibility_" + light) || images.contains("masks." + light))
            lights.push_back(light);
    return lights;
}

// Frames that a truth is to be like, and whose: into `job`.
void choose_mask(const ReferenceArguments& arguments, const RenderedFolder& rendered,
                 const FramesByImage& images, Job& job, Diagnostics& diagnostics) {
    const auto refuse = [&](const char* option, const std::string& why) {
        diagnostics.add({arguments.like, 0, 0}, option, why);
    };
    const std::vector<std::string> lights = lights_with_masks(images, job.shot);
    const bool own_mask = std::ranges::find(lights, arguments.light) != lights.end();
    if (images.contains("visibility") && !own_mask) {
        if (!arguments.light.empty() && !rendered.light.empty() && arguments.light != rendered.light)
            return refuse("--light", fmt::format("visibility in here is of \"{}\"", rendered.light));
        job.light = arguments.light.empty() ? rendered.light : arguments.light;
        job.frames.assign(images.at("visibility").begin(), images.at("visibility").end());
        return;
    }
    if (arguments.light.empty() && lights.size() > 1)
        return refuse("--light",
                      fmt::format("there is a mask of each of {}: whose truth?", fmt::join(lights, ", ")));
    job.light = arguments.light.empty() && !lights.empty() ? lights.front() : arguments.light;
    if (job.light.empty() && !images.empty()) {
        std::vector<std::string> names;
        for (const auto& [name, frames] : images) names.push_back(name);
        return refuse("--signal", fmt::format("no visibility.NNNN.exr in here, but {}: the truth of what?",
                                              fmt::join(names, ", ")));
    }
    if (const auto frames = visibility_frames(arguments.like, diagnostics, job.light)) job.frames = *frames;
}

// Of radiance the frames that have it, or else all that there are.
void choose_radiance(const ReferenceArguments& arguments, const FramesByImage& images, Job& job,
                     Diagnostics& diagnostics) {
    std::set<uint32_t> frames;
    for (const auto& [name, of_image] : images)
        if (name == arguments.signal || !images.contains(arguments.signal))
            frames.insert(of_image.begin(), of_image.end());
    if (frames.empty()) diagnostics.add({arguments.like, 0, 0}, "", "no NAME.NNNN.exr in here");
    job.frames.assign(frames.begin(), frames.end());
}

// What a rendered folder shows: its shot and size, the frames that it has, and where in their pixels they
// look.
std::optional<Job> like_rendered(const ReferenceArguments& arguments, Diagnostics& diagnostics) {
    if (!arguments.view.shot.empty() || !arguments.view.models.empty() || !arguments.size.empty()) {
        diagnostics.add({}, "--like", "says which shot and size; give neither beside it");
        return std::nullopt;
    }
    const auto rendered = read_rendered_frames(arguments.like, diagnostics);
    const auto images = rendered ? images_in(arguments.like, diagnostics) : std::nullopt;
    auto shot = images ? read_completed_shot(rendered->shot, diagnostics) : std::nullopt;
    if (!shot) return std::nullopt;
    Job job{std::move(*shot), {}, {}, ""};
    if (arguments.signal == "visibility")
        choose_mask(arguments, *rendered, *images, job, diagnostics);
    else
        choose_radiance(arguments, *images, job, diagnostics);
    if (job.frames.empty()) return std::nullopt;
    job.shot.size = rendered->size;
    if (!arguments.frames.empty()) {
        const auto range = parse_frames(arguments.frames, job.shot.frames);
        if (!range) return std::nullopt;
        std::erase_if(job.frames, [&](uint32_t f) { return f < (*range)[0] || f > (*range)[1]; });
        if (job.frames.empty())
            diagnostics.add({arguments.like, 0, 0}, "--frames", "none of these has been written there");
    }
    job.jitter = std::ranges::any_of(
        rendered->jitter, [](const auto& frame) { return frame.second != std::array<double, 2>{}; });
    return job;
}

std::optional<Job> prepare(const ReferenceArguments& arguments, Diagnostics& diagnostics) {
    if (!arguments.like.empty()) return like_rendered(arguments, diagnostics);
    auto view = open_view(arguments.view, arguments.out, diagnostics);
    if (!view) return std::nullopt;
    const auto size = arguments.size.empty() ? std::optional(view->shot.size) : parse_size(arguments.size);
    const auto range = parse_frames(arguments.frames, view->shot.frames);
    if (!size || !range) return std::nullopt;
    const MadeUpShot made_up{view->shot.file, view->made_up};
    Job job{std::move(view->shot), made_up, {}, arguments.light};
    job.shot.size = *size;
    for (uint32_t frame = (*range)[0]; frame <= (*range)[1]; ++frame) job.frames.push_back(frame);
    return job;
}

// What is there already and is not to be written over.
void check_outputs(const ReferenceArguments& arguments, const Job& job, Diagnostics& diagnostics) {
    const bool made_up = !job.made_up.text.empty();
    FileList written{arguments.out, fs::path(arguments.out) / "reference.json"};
    if (made_up) written.push_back(job.shot.file);
    spares(written, {files_of_shot(job.shot, made_up), {arguments.like}}, diagnostics);
    job.made_up.may_be_written(diagnostics);
}

// What `open` opens, with a word of what it does meanwhile; nothing after saying why not.
std::unique_ptr<Session> opened(
    const std::function<std::unique_ptr<Session>(Diagnostics&, std::vector<std::string>&, const Told&)>&
        open) {
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    Doing doing;
    auto session = open(diagnostics, warnings, [&](const char* what, double share) { doing(what, share); });
    doing.clear();
    print_warnings(warnings);
    if (!session) std::cerr << diagnostics.text();
    return session;
}

int write_radiance(const ReferenceArguments& arguments, const Job& job) {
    const Shot& shot = job.shot;
    Device device({arguments.device, false});
    const bool lit = arguments.signal == "lit";
    const auto session =
        opened([&](Diagnostics& diagnostics, std::vector<std::string>& warnings, const Told& told) {
            return lit ? open_lit_truth(device, shot, diagnostics, warnings, told)
                       : open_radiance_truth(device, shot, arguments.signal, diagnostics, warnings, told);
        });
    if (!session) return exit_wrong;
    const fs::path folder = arguments.out;
    fs::create_directories(folder);
    job.made_up.write();
    Progress progress("reference", job.frames.size() * uint64_t{arguments.rays});
    for (const uint32_t frame : job.frames) {
        const auto step = [&](uint32_t rays) { progress.step(rays); };
        const PlanarImage truth = lit ? planar(lit_truth(*session, frame, arguments.rays, step).lit)
                                      : radiance_truth(device, *session, frame, arguments.rays, step);
        const fs::path file = folder / fmt::format("{}.{:04}.exr", arguments.signal, frame);
        std::vector<float> rgb;
        for (size_t i = 0; i < truth.planes[0].values.size(); ++i)
            for (size_t c = 0; c < 3; ++c) rgb.push_back(truth.planes[c].values[i]);
        write_png_light(fs::path(file).replace_extension(".png"), truth.width, truth.height, rgb);
        write_exr(file, truth);
    }
    // Whose truth it is. One of visibility that is there says that of each of its frames, and is kept.
    Diagnostics none;
    const auto there = read_reference_info(folder, none);
    if (!there || there->frames.empty())
        write_reference_info(folder, {shot.file.string(), shot.size, false, arguments.rays, {}, {}});
    progress.print(fmt::format("written to {}\n", (folder / "").string()));
    return exit_good;
}

int write_reference(const ReferenceArguments& arguments, const Job& job) {
    const Shot& shot = job.shot;
    Device device({arguments.device, false});
    bool of_lamp = false;
    std::string light;
    const auto session =
        opened([&](Diagnostics& diagnostics, std::vector<std::string>& warnings, const Told& told) {
            const auto chosen = choose_light(shot, job.light, diagnostics);
            of_lamp = chosen && chosen->light;
            if (chosen) light = chosen->name;
            return !chosen   ? nullptr
                   : of_lamp ? open_light_truth(device, shot, chosen->name, diagnostics, warnings, job.jitter,
                                                nullptr, told)
                             : open_truth(device, shot, diagnostics, warnings, job.jitter, nullptr, told);
        });
    if (!session) return exit_wrong;
    const fs::path folder = arguments.out;
    fs::create_directories(folder);
    Diagnostics none;
    const auto there = read_reference_info(folder, none);
    fs::remove(folder / "reference.json");  // comes last: a folder that has it is a complete one
    job.made_up.write();
    OutputWriter host_images(device, folder);
    size_t lost = 0, frames_of_lost = 0;  // pixels; frames with any
    ReferenceInfo info{shot.file.string(), shot.size, shot.analytic.has_value(), {}, {}, light};
    {
        const uint32_t rows = shot.size[1];
        Progress progress("reference", job.frames.size() * uint64_t{rows});
        for (const uint32_t frame : job.frames) {
            if (shot.analytic) {
                session->run_frame(frame, false);  // for the images beside
                write_truth(folder, shot, frame, analytic_truth(shot, frame));
                progress.step(rows);
            } else {
                const auto step = [&](uint32_t more) { progress.step(more); };
                Truth truth = of_lamp ? counted_light_truth(*session, frame, arguments.rays, step)
                                      : counted_truth(*session, frame, arguments.rays, step);
                lost += truth.lost;
                frames_of_lost += truth.lost > 0;
                write_truth(folder, shot, frame, std::move(truth));
            }
            for (const char* name : {"depth", "motion", "normal", "albedo"})
                host_images.write(*session, name, frame);
            info.frames[frame] = {sun_at(shot, frame).to_sun, session->host().jitter(frame),
                                  shot.analytic ? analytic_contact(shot, frame) : std::nullopt};
        }
    }
    if (lost > 0)
        std::cerr << fmt::format(
            "warning: pixels that show what no triangle explains: {} in all, in {} of {} frames; they are no "
            "receivers\n",
            lost, frames_of_lost, job.frames.size());
    if (!info.exact) info.rays = rays_cast(arguments.rays);
    if (there && there->shot == info.shot && there->size == info.size && there->exact == info.exact &&
        there->rays == info.rays && there->light == info.light)
        info.frames.insert(there->frames.begin(), there->frames.end());  // other frames of the same truth
    write_reference_info(folder, info);
    fmt::print("written to {}\n", (folder / "").string());
    return exit_good;
}

}  // namespace

int run_reference(const ReferenceArguments& arguments) {
    if (!light_fits(arguments.signal, arguments.light)) return exit_wrong;
    Diagnostics diagnostics;
    const auto job = prepare(arguments, diagnostics);
    if (job) check_outputs(arguments, *job, diagnostics);
    if (!diagnostics.empty()) std::cerr << diagnostics.text();
    if (!job || !diagnostics.empty()) return exit_wrong;
    if (job->jitter && job->shot.analytic) {
        std::cerr << arguments.like
                  << ": was rendered with jitter, and a closed form knows pixel centres alone: "
                     "render with --no-jitter\n";
        return exit_wrong;
    }
    if (arguments.signal == "visibility") return write_reference(arguments, *job);
    if (!job->jitter) return write_radiance(arguments, *job);
    std::cerr << arguments.like << ": was rendered with jitter, and the truth of " << arguments.signal
              << " is that of pixel centres: render with --no-jitter"
              << (arguments.signal == "lit" ? " --capture lit\n" : "\n");
    return exit_wrong;
}

}  // namespace penumbra
