// SPDX-License-Identifier: MIT
// The penumbra program: a host of the graph like any other. The command line is declared here, one file per
// command.
#include <fcntl.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <limits>
#include <new>

#include "app/colored_errors.h"
#include "app/command_help.h"
#include "app/commands.h"
#include "app/shell_quoted.h"
#include "host/device/device.h"

namespace {

using namespace penumbra;

void add_node_folders(CLI::App* command, std::vector<std::string>& folders) {
    command
        ->add_option("--nodes", folders,
                     "a folder of node types of your own: NAME.json, each with its shader")
        ->allow_extra_args(false);  // `check --nodes DIR a.json b.json`: one folder per --nodes
}

// What to look at; the first is for commands whose help says more.
CLI::Option* add_view(CLI::App* command, ViewArguments& a) {
    CLI::Option* shot = command->add_option(
        "--shot", a.shot, "shot: a file, or the name of a shipped one: lamp, lights/interior ..");
    command->add_option("--model", a.models,
                        "glTF 2.0 files (.glb, .gltf, .vrm) instead, seen as `penumbra shot` says");
    command->add_flag("--ground", a.ground, "put a ground below the model");
    return shot;
}

// What runs on what, for commands that take both (sort_files()).
void add_files(CLI::App* command, std::vector<std::string>& files, ViewArguments& view) {
    command->add_option("files", files,
                        "a pipeline (a file, or the name of a shipped one; default: hybrid_shadows, or "
                        "lights where there is no sun), models, or both");
    add_view(command, view);
}

void add_render(CLI::App& app, RenderArguments& a) {
    CLI::App* c =
        app.add_subcommand("render", "run a pipeline on a shot or a model and write what it puts out");
    add_files(c, a.files, a.view);
    c->add_option("--out", a.out, "folder to write to (default: out/NAME of the shot or model)");
    c->add_option("--frames", a.frames, "A..B: which frames are written (default: the shot's)");
    c->add_flag("--cold", a.cold, "start at A with a reset instead of executing from frame 0");
    c->add_option("--size", a.size, "WxH instead of the shot's size");
    c->add_option("--capture", a.captures, "also write these resources")->delimiter(',');
    c->add_option("--every", a.every, "write every Nth frame")->check(CLI::Range(1u, 1u << 24));
    c->add_option("--set", a.settings, "PATH=VALUE: change the pipeline, as nodes.filter0.params.step=2");
    add_node_folders(c, a.node_folders);
    c->add_option("--device", a.device, "part of a device's name");
    c->add_option("--seed", a.seed, "instead of the shot's seed");
    c->add_option("--light", a.light,
                  "of which of the shot's lights the mask is, where it has several; of a pipeline that takes "
                  "several, the only one");
    c->add_option("--cascade-size", a.cascade_size, "texels along a side of the sun's shadow maps")
        ->check(CLI::Range(16u, 16384u));
    c->add_option("--facts", a.facts, "a,!b: take these as true or false, whatever the scene says");
    c->add_flag("--validate", a.validate,
                "Vulkan validation with synchronisation checks; count texels of every resource that are "
                "not finite or out of range");
    c->add_flag("--no-alias", a.no_alias, "give every resource memory of its own");
    c->add_flag("--no-jitter", a.no_jitter, "rasterise without sub-pixel jitter");
}

void add_view_command(CLI::App& app, ViewCommandArguments& a) {
    CLI::App* c = app.add_subcommand("view", "fly through a shot or a model while a pipeline runs on it");
    add_files(c, a.files, a.view);
    c->add_option("--size", a.size, "WxH that is rendered (default: 640x360)");
    c->add_option("--window", a.window, "WxH of the window (default: 1280x800)");
    c->add_option("--show", a.show, "begin with this resource instead of the pipeline's last output");
    c->add_option("--beside", a.beside,
                  "begin with this on the right: nothing, raw, published, truth or error")
        ->check(CLI::IsMember({"nothing", "raw", "published", "truth", "error"}));
    CLI::Option* out = c->add_option(
        "--out", a.out, "folder for screenshots and flights (default: out/NAME of the shot or model)");
    c->add_option("--set", a.settings, "PATH=VALUE: change the pipeline");
    add_node_folders(c, a.node_folders);
    c->add_option("--device", a.device, "part of a device's name");
    c->add_option("--seed", a.seed, "instead of the shot's seed");
    c->add_option("--light", a.light, "of which of the shot's lights the mask is, where it has several");
    c->add_flag("--validate", a.validate, "Vulkan validation with synchronisation checks");
    c->add_option("--frames", a.frames,
                  "end after so many (default: when the window is closed; headless: 16)")
        ->check(CLI::Range(1u, std::numeric_limits<uint32_t>::max()));
    CLI::Option* headless =
        c->add_option("--headless", a.headless, "PNG file: write what the window would show, and open none")
            ->excludes(out);
    c->add_option("--rays", a.rays, "headless: per pixel of the truth (default: 64)")
        ->check(CLI::Range(4u, 65536u))
        ->needs(headless);
}

void add_plan(CLI::App& app, PlanArguments& a) {
    CLI::App* c = app.add_subcommand("plan", "compile a pipeline and print the plan; no device is needed");
    c->add_option("pipeline", a.pipeline, "pipeline: a file, or the name of a shipped one")->required();
    c->add_option("--size", a.size, "WxH")->required();
    c->add_option("--facts", a.facts, "a,!b: what is known of the scene; facts not named are true");
    CLI::Option* format = c->add_option("--format", a.format, "text, json or dot")
                              ->check(CLI::IsMember({"text", "json", "dot"}));
    c->add_option("--set", a.settings, "PATH=VALUE: change the pipeline");
    c->add_option("--out", a.out, "folder for plan.json with its SPIR-V and tables, instead of the text")
        ->excludes(format);
    c->add_option("--device", a.device,
                  "for the memory, formats and class of a device of this name (\"\": the first), not for a "
                  "made-up one")
        ->each([&a](const std::string&) { a.on_device = true; });
    add_node_folders(c, a.node_folders);
    c->add_flag("--no-jitter", a.no_jitter, "for images that nobody jitters, whoever asks for it");
    c->add_flag("--no-alias", a.no_alias, "give every resource memory of its own");
    c->add_flag("--optimum", a.optimum, "search for the smallest possible heap, up to half a minute");
}

void add_statics(CLI::App& app, StaticsArguments& a) {
    CLI::App* c = app.add_subcommand(
        "statics", "what a driver's compiler made of every pass: registers, spills, memory, occupancy");
    c->add_option("pipelines", a.pipelines, "files or names of shipped pipelines")->required();
    c->add_option("--facts", a.facts, "a,!b: what is known of the scene; facts not named are true");
    c->add_option("--format", a.format, "table or json")->check(CLI::IsMember({"table", "json"}));
    c->add_option("--set", a.settings, "PATH=VALUE: change the pipelines")->allow_extra_args(false);
    c->add_option("--device", a.device, "part of a device's name");
    add_node_folders(c, a.node_folders);
}

void add_reference(CLI::App& app, ReferenceArguments& a) {
    CLI::App* c =
        app.add_subcommand("reference", "write the true visibility of a shot, each frame frozen in time");
    add_view(c, a.view);
    c->add_option(
        "--like", a.like,
        "a folder written by render: of its shot, size and frames, at the very points that it shows");
    c->add_option("--out", a.out, "folder to write to")->required();
    c->add_option("--frames", a.frames, "A..B: which frames are written (default: the shot's)");
    c->add_option("--size", a.size, "WxH instead of the shot's size");
    c->add_option("--light", a.light, "which of the shot's lights, where it has several");
    c->add_option("--signal", a.signal,
                  "visibility, or specular or diffuse: radiance that arrives under a surface's lobe; or lit: "
                  "the whole picture")
        ->check(CLI::IsMember({"visibility", "specular", "diffuse", "lit"}));
    c->add_option("--rays", a.rays, "per pixel (visibility: of a penumbra; analytic scenes need none)")
        ->check(CLI::Range(16u, 1u << 24));
    c->add_option("--device", a.device, "part of a device's name");
}

void add_compare(CLI::App& app, CompareArguments& a) {
    CLI::App* c = app.add_subcommand("compare", "measure a rendered visibility against a reference");
    c->add_option("image", a.image, "folder written by render")->required();
    c->add_option("reference", a.reference, "folder written by reference")->required();
    c->add_option("--also", a.also, "the same images under another seed")->allow_extra_args(false);
    c->add_option("--frames", a.frames, "A..B (default: those that all folders have)");
    c->add_option(
         "--signal", a.signal,
         "what to compare: visibility, transmittance (its colour), specular or diffuse radiance, or the "
         "pictures lit or color")
        ->check(CLI::IsMember({"visibility", "transmittance", "specular", "diffuse", "lit", "color"}));
    c->add_option("--picture", a.picture, "PNG: of lit or color, the last frame of both beside each other");
    c->add_option("--light", a.light, "of an image with a mask for each of several lights: whose");
    c->add_option("--mask", a.mask, "EXR; only pixels where its first channel is above 0 are measured");
    c->add_option("--border", a.border, "leave out this many pixels along the image's border");
    c->add_flag("--json", a.json, "print JSON");
    c->add_option(
        "--whole-rays", a.whole_rays,
        "the image's rays without intervals: how many answers differ (captures undecided_words, hits)");
}

void add_report(CLI::App& app, ReportArguments& a) {
    CLI::App* c = app.add_subcommand(
        "report",
        "measure pipelines on shots, beside brute force; writes index.html, results.json, results.csv");
    c->add_option("--out", a.out, "folder to write to")->required();
    c->add_option("--shots", a.shots, "files or names of shipped shots (default: all of these)")
        ->delimiter(',');
    c->add_option("--pipelines", a.pipelines,
                  "files or names of shipped pipelines (default: all that can run)")
        ->delimiter(',');
    c->add_option("--signal", a.signal,
                  "what is judged: visibility, or radiance that arrives under the specular or diffuse lobe")
        ->check(CLI::IsMember({"visibility", "specular", "diffuse"}));
    CLI::Option* quick =
        c->add_flag("--quick", a.quick, "small, few frames, two shots: minutes on two cores");
    c->add_flag(
         "--front", a.front,
         "speed against error alone: frame 15 of each shot as it moves, 640x360 unless --size says else")
        ->excludes(quick);
    c->add_option("--size", a.size, "WxH of the shots");
    c->add_option("--light", a.light,
                  "a light of the shots that is near, whose masks are measured instead of the sun's");
    c->add_option("--seeds", a.seeds, "repetitions of every run")->check(CLI::Range(1u, 64u));
    c->add_option("--rounds", a.rounds, "times that every pass is timed; the least counts")
        ->check(CLI::Range(1u, 64u));
    c->add_option("--rays", a.rays, "per pixel of a penumbra, of the truth")->check(CLI::Range(1u, 65536u));
    c->add_flag("--again", a.again,
                "measure anew what an earlier run with the same inputs has left in the folder");
    add_node_folders(c, a.node_folders);
    c->add_option("--device", a.device, "part of a device's name");
}

void add_gates(CLI::App& app, GatesArguments& a) {
    CLI::App* c = app.add_subcommand(
        "gates",
        "measure pipelines on straight penumbrae, or radiance in a furnace and a room, with a known answer; "
        "prints Markdown tables");
    c->add_option("pipelines", a.pipelines, "files or names of shipped pipelines")->required();
    c->add_option("--signal", a.signal, "visibility, or specular or diffuse radiance")
        ->check(CLI::IsMember({"visibility", "specular", "diffuse"}));
    c->add_option("--parts", a.parts,
                  "of still, moving, jump, tilted; of radiance: furnace, still, moving, lag (default: all)")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember({"still", "moving", "jump", "tilted", "furnace", "lag"}));
    c->add_option("--seeds", a.seeds, "repetitions of every run (default: 16; of radiance: 4)")
        ->check(CLI::Range(1u, 1024u));
    // What is none lies in no range, and outside of none.
    const auto is_number = [](const std::string& text) {
        return std::isnan(std::strtod(text.c_str(), nullptr)) ? text + " is no number" : "";
    };
    c->add_option("--edge-deg", a.edge_deg, "direction of the edge of still, moving and jump (default: 20)")
        ->check(CLI::Range(-360.0, 360.0))
        ->check(is_number);
    c->add_option("--widths", a.widths_px,
                  "of the penumbrae of still, moving and jump, in pixels (default: 8,16,32)")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::Range(0.5, 4096.0))
        ->check(is_number);
    add_node_folders(c, a.node_folders);
    c->add_option("--device", a.device, "part of a device's name");
}

void add_shot(CLI::App& app, ShotArguments& a) {
    CLI::App* c =
        app.add_subcommand("shot", "write the shot that `render MODEL` makes up, as a start for your own");
    c->add_option("models", a.view.models, "glTF 2.0 files (.glb, .gltf, .vrm), each where it says")
        ->required();
    c->add_option("--out", a.out, "file to write (default: NAME.shot.json here)");
    c->add_flag("--ground", a.view.ground, "put a ground below the model");
}

void add_explain(CLI::App& app, ExplainArguments& a) {
    CLI::App* c = app.add_subcommand(
        "explain",
        "draw what one pixel sees of the sun, what rays around it say, what is "
        "proved of whole tiles, where a budget of rays went, or where the time of rendered frames went");
    c->add_option("--out", a.out, "SVG file to write; of --budget a PNG")->required();
    CLI::Option* shot = add_view(c, a.view);
    CLI::Option* pixel = c->add_option(
        "--pixel", a.pixel,
        "X,Y from the upper left corner (default: where most triangles hide a part of the sun)");
    CLI::Option* size = c->add_option("--size", a.size, "WxH instead of the shot's size");
    CLI::Option* frame = c->add_option("--frame", a.frame, "which frame (default: the first)");
    CLI::Option* samples = c->add_option("--samples", a.samples, "of the sun: 64, 128 or 256");
    samples->check(CLI::IsMember({64, 128, 256}));
    CLI::Option* no_jitter = c->add_flag("--no-jitter", a.no_jitter, "rasterise without sub-pixel jitter");
    CLI::Option* gather = c->add_flag(
        "--gather", a.gather,
        "the rays of the pixels around as tests of its sun, instead of the triangles that hide it");
    gather->excludes(samples);
    c->add_flag("--budget", a.budget,
                "how many rays shadows.json gives each pixel, after all frames before: none grey, 1 to 32 "
                "from blue to white")
        ->excludes(gather)
        ->excludes(samples)
        ->excludes(pixel);
    c->add_flag(
         "--beams", a.beams,
         "why the node beams decides a tile as lit or as dark, or leaves it to its pixels: a picture of "
         "each, or of the tile of --pixel")
        ->excludes(gather)
        ->excludes(samples)
        ->excludes("--budget");
    CLI::Option* device = c->add_option("--device", a.device, "part of a device's name");
    CLI::Option* costs =
        c->add_option("--costs", a.costs, "report.json files of render: a bar of CPU milliseconds for each");
    for (CLI::Option* of_a_frame : {shot, pixel, size, frame, samples, no_jitter, gather, device})
        costs->excludes(of_a_frame);
    for (const char* of_a_frame : {"--model", "--ground", "--budget", "--beams"}) costs->excludes(of_a_frame);
}

void add_bench(CLI::App& app, BenchArguments& a) {
    CLI::App* c =
        app.add_subcommand("bench", "measure what pipelines cost: every pass, the frame, start-up, memory");
    c->add_option("pipelines", a.pipelines, "files or names of shipped pipelines, which take turns")
        ->required();
    c->add_option("--shots", a.shots, "files or names of shipped shots (default: colonnade, engine, lamp)")
        ->delimiter(',')
        ->allow_extra_args(false);
    c->add_option("--sizes", a.sizes, "WxH,... (default: 640x360)")->delimiter(',')->allow_extra_args(false);
    c->add_option("--frames", a.frames, "A..B: which are timed, of those from 0 on (default: 8..15)");
    c->add_option("--rounds", a.rounds, "times that everything is run (default: 5)")
        ->check(CLI::Range(1u, 1024u));
    c->add_flag("--still", a.still, "shots cut to their first keys: nothing moves but the jitter");
    c->add_flag("--still-camera", a.still_camera, "the camera stays where a shot begins")
        ->excludes("--still");
    c->add_option("--light", a.light, "which of the shots' lights, where they have several");
    c->add_option("--format", a.format, "table (Markdown) or json")->check(CLI::IsMember({"table", "json"}));
    c->add_option("--set", a.settings, "PATH=VALUE: change the pipelines");
    add_node_folders(c, a.node_folders);
    c->add_option("--device", a.device, "part of a device's name");
}

int dispatch(const CLI::App& app, const RenderArguments& render, const PlanArguments& plan,
             const CheckArguments& check, const NodesArguments& nodes, const ReferenceArguments& reference,
             const CompareArguments& compare, const ReportArguments& report, const GatesArguments& gates,
             const ExplainArguments& explain, const StaticsArguments& statics, const BenchArguments& bench,
             const ShotArguments& shot, const ViewCommandArguments& view) {
    if (app.got_subcommand("view")) return run_view(view);
    if (app.got_subcommand("shot")) return run_shot(shot);
    if (app.got_subcommand("statics")) return run_statics(statics);
    if (app.got_subcommand("bench")) return run_bench(bench);
    if (app.got_subcommand("explain")) return run_explain(explain);
    if (app.got_subcommand("gates")) return run_gates(gates);
    if (app.got_subcommand("report")) return run_report(report);
    if (app.got_subcommand("reference")) return run_reference(reference);
    if (app.got_subcommand("compare")) return run_compare(compare);
    if (app.got_subcommand("render")) return run_render(render);
    if (app.got_subcommand("plan")) return run_plan(plan);
    if (app.got_subcommand("check")) return run_check(check);
    if (app.got_subcommand("nodes")) return run_nodes(nodes);
    return run_devices();
}

// Else a number that begins with 0 would be octal.
void read_decimals(CLI::App& app) {
    const auto without_zeros = [](std::string text) {
        const bool digits = !text.empty() && text.find_first_not_of("0123456789") == text.npos;
        return digits ? text.substr(std::min(text.find_first_not_of('0'), text.size() - 1)) : text;
    };
    for (CLI::App* command : app.get_subcommands({}))
        for (CLI::Option* option : command->get_options())
            if (option->get_type_name().starts_with("UINT")) option->transform(without_zeros);
}

// The first option whose value is the empty text, which names nothing; of a device it means the first.
std::string empty_option(const CLI::App& app) {
    for (const CLI::App* command : app.get_subcommands())
        for (const CLI::Option* option : command->get_options())
            if (option->get_name() != "--device")
                for (const std::string& text : option->results())
                    if (text.empty()) return option->get_name();
    return "";
}

int run(int argc, char** argv) {
    CLI::App app("penumbra: a render graph for ray-traced shadows and reflections", "penumbra");
    app.require_subcommand(1);
    app.set_version_flag("--version", PENUMBRA_VERSION);
    RenderArguments render;
    PlanArguments plan;
    CheckArguments check;
    NodesArguments nodes;
    ReferenceArguments reference;
    CompareArguments compare;
    ReportArguments report;
    GatesArguments gates;
    ExplainArguments explain;
    ShotArguments shot;
    StaticsArguments statics;
    ViewCommandArguments view;
    add_render(app, render);
    add_view_command(app, view);
    add_plan(app, plan);
    add_reference(app, reference);
    add_compare(app, compare);
    add_report(app, report);
    add_gates(app, gates);
    add_explain(app, explain);
    add_shot(app, shot);
    add_statics(app, statics);
    BenchArguments bench;
    add_bench(app, bench);
    CLI::App* checking = app.add_subcommand("check", "print every error of these pipelines");
    checking->add_option("pipelines", check.pipelines, "files or names of shipped pipelines")->required();
    checking->add_flag("--page", check.page, "print a page about them as well, as docs/pipeline_list.md");
    add_node_folders(checking, check.node_folders);
    CLI::App* n = app.add_subcommand("nodes", "list the node types, or describe one");
    n->add_option("type", nodes.type, "a node type");
    n->add_option("--format", nodes.format,
                  "text, json, md, schema, node-schema or plan-schema (JSON Schemas of pipelines, of "
                  "declarations and of plans), or "
                  "vocabulary (a page of the keys of both), or page (docs/nodes.md), or glsl (node.glsl)")
        ->check(CLI::IsMember(
            {"text", "json", "md", "page", "schema", "node-schema", "plan-schema", "vocabulary", "glsl"}));
    add_node_folders(n, nodes.node_folders);
    app.add_subcommand("devices", "list the Vulkan devices");
    std::string shell;
    CLI::App* completion =
        app.add_subcommand("completion", "print a script that completes commands and options");
    completion->add_option("shell", shell, "bash, zsh or fish")
        ->required()
        ->check(CLI::IsMember({"bash", "zsh", "fish"}));
    read_decimals(app);
    add_examples(app);
    if (argc == 1) {  // no mistake, so not in its colour
        std::fputs(app.help().c_str(), stderr);
        return exit_wrong;
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& e) {
        return app.exit(e);
    } catch (const CLI::ParseError& e) {
        std::cerr << wrong_words(app, e, {argv + 1, argv + argc});
        return exit_wrong;
    }
    if (const std::string option = empty_option(app); !option.empty()) {
        std::cerr << option << ": the text is empty\n";
        return exit_wrong;
    }
    if (completion->parsed()) {
        std::cout << completion_script(app, shell);
        return exit_good;
    }
    for (int i = 0; i < argc; ++i) report.command_line += (i ? " " : "") + shell_quoted(argv[i]);
    bench.command_line = report.command_line;
    return dispatch(app, render, plan, check, nodes, reference, compare, report, gates, explain, statics,
                    bench, shot, view);
}

// A standard stream that is closed gives its number to the next file that is opened, which would then be
// written into. What stands in for it can be opened and not written, so that output is not lost without a
// word.
void occupy_standard_streams() {
    for (int stream = 0; stream < 3; ++stream)
        if (::fcntl(stream, F_GETFD) < 0) ::open("/dev/null", O_RDONLY);
}

// Lavapipe frees what a frame was rasterised with while the next commands run. Of many triangles that is so
// much memory that the kernel takes milliseconds to get it back, which would count as the first pass's
// (docs/notes/2026-11-24-freed-memory.md): freed memory stays here.
void keep_freed_memory() {
#ifdef __GLIBC__
    ::mallopt(M_TRIM_THRESHOLD, 1 << 30);
    ::mallopt(M_MMAP_THRESHOLD, 32 << 20);
#endif
}

}  // namespace

int main(int argc, char** argv) {
    const ColoredErrors colors;
    int code = exit_failed;
    try {
        occupy_standard_streams();
        keep_freed_memory();
        code = run(argc, argv);
    } catch (const std::bad_alloc&) {
        std::cerr << "penumbra: there is not enough memory\n";
    } catch (const std::filesystem::filesystem_error& e) {
        std::cerr << e.path1().string() << ": cannot be made or written: " << e.code().message() << "\n";
    } catch (const NoSuchDevice& e) {
        std::cerr << "penumbra: " << e.what() << "\n";
        code = exit_wrong;
    } catch (const std::exception& e) {  // DeviceError and VulkanError among them: their texts are for people
        std::cerr << "penumbra: " << e.what() << "\n";
    }
    std::cout.flush();
    if (std::fflush(stdout) == 0 && std::cout && !std::ferror(stdout)) return code;
    std::fputs("penumbra: standard output cannot be written\n", stderr);
    return code == exit_good ? exit_failed : code;
}
