// SPDX-License-Identifier: MIT
// penumbra view: a window that a shot is flown through in, or, headless, the picture that such a window would
// show.
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_vulkan.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <iostream>
#include <span>

#include "app/commands.h"
#include "app/input_files.h"
#include "app/progress.h"
#include "app/shipped_files.h"
#include "app/text_file.h"
#include "app/view/panels.h"
#include "app/view/snapshot.h"
#include "app/view/window.h"
#include "app/view_source.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using namespace viewer;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// Dear ImGui's context, without a file of its own.
struct Interface {
    Interface() {
        ImGui::CreateContext();
        ImGui::GetIO().IniFilename = nullptr;
        ImGui::StyleColorsDark();
        ImGui::GetStyle().WindowRounding = ImGui::GetStyle().WindowBorderSize = 0;
    }
    ~Interface() { ImGui::DestroyContext(); }
};

struct Job {
    ViewSource source;
    std::string base;  // the shot's text
    StageWish wish;
    std::vector<std::string> pipelines;  // to choose from
    Beside beside = Beside::nothing;
    VkExtent2D window{};
    fs::path folder;
};

fs::path json_beside(const fs::path& png) {
    return fs::path(png).replace_extension(".json");
}

// The picture without a window, and the JSON beside it.
bool may_be_written(const ViewCommandArguments& a, const Job& job) {
    Diagnostics diagnostics;
    const auto pipeline = shipped_file(job.wish.pipeline, shipped_root(), shipped_pipelines, diagnostics);
    const bool good =
        pipeline && spares({a.headless, json_beside(a.headless)},
                           {files_of_shot(job.source.shot, !job.source.made_up.empty()),
                            files_of_pipelines({pipeline->string()}), files_of_nodes(a.node_folders)},
                           diagnostics);
    std::cerr << diagnostics.text();
    return good;
}

// Whether all that is said of the picture without a window has a say in it.
bool fits_headless(const ViewCommandArguments& a) {
    if (!a.headless.empty() && fs::path(a.headless).extension() != ".png") {
        fmt::print(stderr, "--headless: {} is written as a PNG: end its name in .png\n", a.headless);
        return false;
    }
    if (a.rays && a.beside != "truth" && a.beside != "error") {
        fmt::print(stderr, "--rays: are the truth's, which --beside truth or error shows\n");
        return false;
    }
    return true;
}

std::optional<Job> prepare(const ViewCommandArguments& a) {
    if (!fits_headless(a)) return std::nullopt;
    Diagnostics diagnostics;
    const auto given = sort_files(a.files, a.view, diagnostics);
    const auto size = parse_size(a.size);
    const auto window = parse_size(a.window, "--window");
    const fs::path folder =
        !a.out.empty() || !given ? fs::path(a.out) : fs::path("out") / view_name(given->view);
    auto source = given ? open_view(given->view, folder, diagnostics) : std::nullopt;
    if (!source) std::cerr << diagnostics.text();
    if (!source || !size || !window) return std::nullopt;
    if (source->shot.analytic) {
        std::cerr << source->shot.file.string()
                  << ": an analytic scene has a camera of its own, and nobody can fly in it: give a shot of "
                     "a model\n";
        return std::nullopt;
    }
    Job job{std::move(*source), "", {}, {}, Beside::nothing, {(*window)[0], (*window)[1]}, folder};
    job.base = job.source.text;
    job.wish.pipeline = pipeline_for(*given, &job.source.shot);
    job.wish.settings = a.settings;
    job.wish.node_folders = a.node_folders;
    job.wish.size = *size;
    job.wish.light = a.light;
    job.wish.seed = a.seed;
    job.pipelines.push_back(job.wish.pipeline);
    for (const fs::path& file : shipped_files(shipped_root(), shipped_pipelines))
        if (const std::string name = file.stem().string(); name != job.wish.pipeline)
            job.pipelines.push_back(name);
    const auto beside = std::ranges::find(beside_names, a.beside);
    job.beside = static_cast<Beside>(beside - beside_names.begin());
    if (!a.headless.empty() && !may_be_written(a, job)) return std::nullopt;
    return job;
}

void write_screenshot(const fs::path& png, Canvas& canvas, const Live& live, const Panels& panels) {
    const VkExtent2D extent = canvas.image().extent;
    write_file(png, png_of_rgba(extent.width, extent.height, canvas.rgba()));
    write_text(json_beside(png), snapshot_text(live, panels.places(), panels.frames_per_second));
}

// Writes FOLDER/view.0001.png, with the first number that is free; in words, what came of it: a full disk
// ends no view.
std::string keep(const fs::path& folder, const char* name, const char* suffix,
                 const std::function<void(const fs::path&)>& write) {
    try {
        fs::create_directories(folder);
        fs::path file;
        for (int i = 1; file.empty() || fs::exists(file); ++i)
            file = folder / fmt::format("{}.{:04}{}", name, i, suffix);
        write(file);
        return "written: " + file.generic_string();
    } catch (const FileError& error) {
        return error.what();
    } catch (const fs::filesystem_error& error) {
        return error.what();
    }
}

// The wishes of the command line; false, and it has been said why, where one cannot be had.
bool first_wishes(Live& live, const ViewCommandArguments& a, Beside beside) {
    Doing doing;
    bool good = live.open([&](const char* what, double share) { doing(what, share); });
    doing.clear();
    print_warnings(live.warnings());
    if (good && !a.show.empty()) {
        live.show(a.show);
        good = live.shown() == a.show;
    }
    if (good) {
        live.compare(beside);
        good = live.beside() == beside;
    }
    if (!good) std::cerr << live.error() << (live.error().ends_with('\n') ? "" : "\n");
    return good;
}

// The interface of this frame; what was asked for by keys is the result.
Asked build(Live& live, Panels& panels, FlightInput& next, std::span<const int> pressed = {}) {
    ImGui_ImplVulkan_NewFrame();
    ImGui::NewFrame();
    const Asked asked = panels.build(live, next, pressed);
    ImGui::Render();
    return asked;
}

int run_headless(Device& device, const ViewCommandArguments& a, Live& live, const Job& job) {
    const Interface interface;
    Panels panels(job.pipelines);
    Canvas canvas(device, job.window);
    ImGui::GetIO().DisplaySize = {static_cast<float>(job.window.width),
                                  static_cast<float>(job.window.height)};
    const bool judged = live.beside() == Beside::truth || live.beside() == Beside::error;
    live.flight().play(!judged);
    const uint32_t frames = a.frames ? a.frames : 16, most_rays = a.rays.value_or(64);
    Clock::time_point start = Clock::now();
    Picture picture;
    {
        Progress progress("view", frames + (judged ? most_rays : 0));
        for (uint32_t frame = 0; frame < frames; ++frame) {
            FlightInput input;
            input.seconds = 1 / live.shot().fps;
            if (frame == 1) start = Clock::now();  // the first one makes what lasts
            live.frame(input, 0);
            picture = live.picture();
            build(live, panels, input);
            panels.picture_note = picture.note;
            canvas.draw(picture, panels.picture_area(live), ImGui::GetDrawData());
            progress.step();
        }
        if (frames > 1) panels.frames_per_second = (frames - 1) / seconds_since(start);
        for (uint32_t rays = 0; judged && rays < most_rays;) {
            live.frame({}, 1e9);
            const auto known = live.judgement();
            for (; rays < (known ? known->rays : 0) && rays < most_rays; ++rays) progress.step();
        }
    }
    picture = live.picture();
    panels.picture_note = picture.note;
    for (int i = 0; i < 2; ++i) {  // a caption of more lines is as large as it should be in the second
        FlightInput none;
        build(live, panels, none);
    }
    canvas.draw(picture, panels.picture_area(live), ImGui::GetDrawData());
    const fs::path png = a.headless;
    if (png.has_parent_path()) fs::create_directories(png.parent_path());
    write_screenshot(png, canvas, live, panels);
    fmt::print("{}: {}x{}, {} frames, {:.1f} frames/s, {:.1f} CPU ms of passes\n", png.generic_string(),
               live.size()[0], live.size()[1], frames, panels.frames_per_second, live.cpu_ms());
    return exit_good;
}

int run_window(Device& device, const ViewCommandArguments& a, Live& live, const Job& job) {
    const Interface interface;
    Panels panels(job.pipelines);
    Window window(device, job.window, "penumbra view: " + live.shot().name);
    Canvas canvas(device, job.window);
    FlightInput input;
    Clock::time_point last = Clock::now(), looked = last;
    while (window.poll()) {
        const double seconds = seconds_since(last);
        last = Clock::now();
        panels.frames_per_second = panels.frames_per_second > 0 && seconds < 1
                                       ? 1 / (0.9 / panels.frames_per_second + 0.1 * seconds)
                                       : 1 / seconds;
        input.seconds = std::min(seconds, 0.25);  // whoever waited for a pipeline has not flown on meanwhile
        window.fly(input);
        if (seconds_since(looked) > 0.25) {
            looked = Clock::now();
            live.reload_changed();
        }
        live.frame(input, 60);
        input = {};
        const Picture picture = live.picture();
        panels.picture_note = picture.note;
        canvas.resize(window.extent());
        ImGui_ImplGlfw_NewFrame();
        const Area area = panels.picture_area(live);
        const Asked asked = build(live, panels, input, window.pressed());
        canvas.draw(picture, area, ImGui::GetDrawData());
        window.present(canvas);
        if (asked.screenshot)
            panels.said = keep(job.folder, "view", ".png",
                               [&](const fs::path& file) { write_screenshot(file, canvas, live, panels); });
        if (asked.write_record && !live.recorded().empty()) {
            panels.said = keep(job.folder, "flight", ".shot.json", [&](const fs::path& file) {
                write_text(file, live.recorded().shot_text(job.base, live.shot(), job.folder));
            });
            if (live.recorded().has_more(live.shot().fps))
                panels.said +=
                    fmt::format(", with the first {} frames: a shot has no more", FlightRecord::most_frames);
        }
        if (a.frames > 0 && live.frames() >= a.frames) break;
    }
    return exit_good;
}

int view(const ViewCommandArguments& a, Job job) {
    std::optional<WindowSystem> system;
    DeviceOptions options{.name = a.device, .validation = a.validate};
    if (a.headless.empty()) {
        system.emplace();
        options.surface_extensions = system->surface_extensions();
    }
    Device device(options);
    const uint32_t most = device_table(handles_of(device)).max_image_extent;
    if (std::max(job.window.width, job.window.height) > most) {
        fmt::print(stderr, "--window: {}x{} exceeds the device's largest image, {} per axis\n",
                   job.window.width, job.window.height, most);
        return exit_wrong;
    }
    int code = exit_wrong;
    {
        Live live(device, job.source.shot, job.wish);
        if (first_wishes(live, a, job.beside))
            code = a.headless.empty() ? run_window(device, a, live, job) : run_headless(device, a, live, job);
    }
    for (const std::string& message : device.messages()) std::cerr << message << "\n";
    return code == exit_good && device.message_count() > 0 ? exit_failed : code;
}

}  // namespace

int run_view(const ViewCommandArguments& arguments) {
    auto job = prepare(arguments);
    return job ? view(arguments, std::move(*job)) : exit_wrong;
}

}  // namespace penumbra
