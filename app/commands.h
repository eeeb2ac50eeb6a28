// SPDX-License-Identifier: MIT
// The program's commands. Each returns the process's exit code: 0 good, 1 the work failed, 2 the command or a
// file is wrong.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace penumbra {

// How long `report` and `plan --optimum` look for the smallest possible heap, in steps of a microsecond:
// found at once where the packing meets the live bound. Who renders, or asks for a plan alone, does not wait
// for it.
inline constexpr uint64_t report_search_nodes = 20'000'000, render_search_nodes = 100'000;

enum ExitCode : int { exit_good = 0, exit_failed = 1, exit_wrong = 2 };

// What to look at: a shot, or a model that one is made up for.
struct ViewArguments {
    std::string shot;
    std::vector<std::string> models;  // files, instead of a shot
    bool ground = false;              // below the model
};

struct RenderArguments {
    std::vector<std::string> files;  // a pipeline, models, or both
    std::string out;                 // empty: out/<the shot's name>
    ViewArguments view;
    std::string frames;  // "A..B", inclusive; empty: all of the shot's
    bool cold = false;   // start at A with a reset instead of executing from frame 0
    std::string size;    // "WxH"; empty: the shot's
    std::vector<std::string> captures;
    uint32_t every = 1;  // write every Nth of the selected frames
    std::vector<std::string> settings;
    std::vector<std::string> node_folders;  // --nodes
    std::string device;
    std::optional<uint32_t> seed;
    std::string light;  // of the shot's; empty: the only one
    std::optional<uint32_t> cascade_size;
    std::string facts;  // "a,!b": instead of what the scene says
    bool validate = false;
    bool no_alias = false;
    bool no_jitter = false;
};

struct ViewCommandArguments {
    std::vector<std::string> files;  // a pipeline, models, or both
    ViewArguments view;
    std::string out;  // for screenshots and flights; empty: out/<the shot's name>
    std::string size = "640x360", window = "1280x800";
    std::string show, beside = "nothing";  // what the picture begins with
    std::vector<std::string> settings, node_folders;
    std::string device, light;
    std::optional<uint32_t> seed;
    bool validate = false;
    std::string headless;          // a PNG file, instead of a window
    uint32_t frames = 0;           // after which it ends; 0: when the window is closed
    std::optional<uint32_t> rays;  // headless: of the truth; else 64
};

struct PlanArguments {
    std::string pipeline, size, facts, format = "text", device, out;
    std::vector<std::string> settings, node_folders;
    bool no_jitter = false, no_alias = false, optimum = false, on_device = false;
};

struct StaticsArguments {
    std::vector<std::string> pipelines;
    std::string facts, format = "table", device;
    std::vector<std::string> settings, node_folders;
};

struct CheckArguments {
    std::vector<std::string> pipelines, node_folders;
    bool page = false;  // about them, where all are right
};

struct NodesArguments {
    std::string type, format = "text";
    std::vector<std::string> node_folders;
};

struct ReferenceArguments {
    ViewArguments view;
    std::string like;  // a folder that `render` has written: its shot, size, frames and jitter
    std::string out, frames, size, light, device;
    std::string signal = "visibility";  // or specular, diffuse, lit
    uint32_t rays = 1024;               // per pixel
};

struct ShotArguments {
    ViewArguments view;
    std::string out;  // a file; empty: MODEL.shot.json
};

struct CompareArguments {
    std::string image, reference;   // folders
    std::vector<std::string> also;  // folders of the same images under other seeds
    std::string frames, mask;
    std::string light;                  // of a pipeline that takes several: whose mask is compared
    std::string signal = "visibility";  // or transmittance, specular, diffuse, lit, color
    std::string picture;                // PNG to write, of pictures: the last frame's, beside each other
    uint32_t border = 0;                // pixels along the image's border that are left out
    bool json = false;
    std::string whole_rays;  // folder of the same image, its rays traced without intervals
};

struct ReportArguments {
    std::string out;
    std::vector<std::string> shots, pipelines;  // files, or names of shipped ones; empty: all shipped ones
    std::string signal = "visibility";          // or specular, diffuse
    bool quick = false;
    bool front = false;                           // speed against error alone
    bool again = false;                           // measure what an earlier run has left behind, too
    std::string size;                             // "WxH"; empty: the study's
    std::string light;                            // a lamp of the shots; empty: the sun
    std::optional<uint32_t> seeds, rounds, rays;  // else the study's
    std::vector<std::string> node_folders;
    std::string device;
    std::string command_line;  // as it was given, for the report
};

struct GatesArguments {
    std::vector<std::string> pipelines;  // files, or names of shipped ones
    std::string signal = "visibility";   // or specular, diffuse
    std::vector<std::string> parts;      // empty: all that the signal has
    std::optional<uint32_t> seeds;       // else the study's
    std::optional<double> edge_deg;      // else the study's
    std::vector<double> widths_px;       // empty: the study's
    std::vector<std::string> node_folders;
    std::string device;
};

// What pipelines cost.
struct BenchArguments {
    std::vector<std::string> pipelines;  // files, or names of shipped ones
    std::vector<std::string> shots{"colonnade", "engine", "lamp"}, sizes{"640x360"};
    std::string frames = "8..15";  // timed, of those from 0 on
    uint32_t rounds = 5;
    bool still = false, still_camera = false;
    std::string format = "table";
    std::string light;  // of the shots, where they have several; empty: the only one, or all
    std::vector<std::string> settings, node_folders;
    std::string device;
    std::string command_line;  // as it was given, for the JSON
};

// A figure of one pixel of a shot, or of what rendered frames cost.
struct ExplainArguments {
    ViewArguments view;
    std::string out;
    std::string pixel;  // "X,Y" from the image's upper left corner; empty: the one with the most triangles
    std::string size;   // "WxH"; empty: the shot's
    uint32_t frame = 0;
    uint32_t samples = 128;  // of the sun
    bool no_jitter = false;
    bool beams = false;   // what is proved of whole tiles
    bool gather = false;  // what the rays around say, instead of what triangles hide
    bool budget = false;  // how many rays each pixel got
    std::string device;
    std::vector<std::string> costs;  // report.json files of render, instead of a shot
};

int run_render(const RenderArguments& arguments);
int run_view(const ViewCommandArguments& arguments);
int run_plan(const PlanArguments& arguments);
int run_statics(const StaticsArguments& arguments);
int run_check(const CheckArguments& arguments);
int run_nodes(const NodesArguments& arguments);
int run_devices();
int run_reference(const ReferenceArguments& arguments);
int run_compare(const CompareArguments& arguments);
int run_report(const ReportArguments& arguments);
int run_shot(const ShotArguments& arguments);
int run_gates(const GatesArguments& arguments);
int run_bench(const BenchArguments& arguments);
int run_explain(const ExplainArguments& arguments);

// "1280x720"; nothing where it is not two positive numbers.
std::optional<std::array<uint32_t, 2>> parse_size(const std::string& text,
                                                  std::string_view option = "--size");

}  // namespace penumbra
