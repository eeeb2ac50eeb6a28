// SPDX-License-Identifier: MIT
// penumbra gates: pipelines against straight penumbrae whose truth is known, as Markdown tables beside what
// is asked of them (docs/accuracy.md).
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "app/commands.h"
#include "app/counted.h"
#include "app/gates/gates.h"
#include "app/gates/radiance_gates.h"
#include "app/markdown.h"
#include "app/node_folders.h"
#include "app/progress.h"
#include "app/report/contenders.h"
#include "app/wrong.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using namespace gates;

// What is asked at 8, 16 and 32 pixels; other widths have no gate.
struct Asked {
    const char *first, *last, *flicker, *moving, *k90;
};
const std::map<double, Asked> asked_of{{8, {">= 12", ">= 60", "", ">= 6", "<= 2"}},
                                       {16, {">= 28", ">= 250", "<= 1", ">= 14", "<= 2"}},
                                       {32, {">= 67", ">= 1500", "<= 1", ">= 34", "<= 2"}}};

// Nothing but visibility is run: no light, no anti-aliasing.
std::optional<CheckedPipeline> mask_pipeline(const fs::path& file, const NodeSet& nodes,
                                             Diagnostics& diagnostics) {
    auto pipeline = load_pipeline(file, {}, diagnostics);
    if (!pipeline) return std::nullopt;
    std::erase_if(pipeline->outputs, [](const OutputName& o) { return o.name != "visibility"; });
    if (pipeline->outputs.empty()) {
        diagnostics.add({file.string(), 0, 0}, "outputs", "the pipeline puts out no \"visibility\"");
        return std::nullopt;
    }
    return check(*pipeline, nodes, diagnostics);
}

std::string text_of(const Estimate& e) {
    if (!e.low) return fmt::format("{:.3g}", e.median);
    return fmt::format("{:.3g} [{:.3g}, {:.3g}]", e.median, *e.low, *e.high);
}

std::string asked_text(double width, const char* Asked::*what) {
    const auto found = asked_of.find(width);
    return found == asked_of.end() ? "" : found->second.*what;
}

uint32_t steps_of(const Study& study, const std::set<std::string>& parts) {
    const auto widths = static_cast<uint32_t>(study.widths_px.size());
    uint32_t runs = 0;
    if (parts.contains("still")) runs += widths * study.seeds;
    if (parts.contains("moving"))
        runs += widths * study.seeds * static_cast<uint32_t>(study.speeds_px.size());
    if (parts.contains("jump")) runs += 4 * widths * study.seeds;
    if (parts.contains("tilted"))
        runs += static_cast<uint32_t>(study.tilts_deg.size() * study.tilted_edges_deg.size() *
                                      study.tilted_widths_px.size()) *
                study.tilted_seeds;
    return runs;
}

bool print_still(const Bench& bench, const Progress& progress) {
    progress.print(markdown_head({"penumbra, px", "first frame", "asked",
                                  fmt::format("frame {}", bench.study.still_frames - 1), "asked",
                                  "flicker of the penumbra / 255", "of all", "asked"}));
    for (const double width : bench.study.widths_px) {
        const auto still = measure_still(bench, width);
        if (!still) return false;
        progress.print(
            markdown_row({fmt::format("{:g}", width), text_of(still->first), asked_text(width, &Asked::first),
                          text_of(still->last), asked_text(width, &Asked::last), text_of(still->flicker),
                          text_of(still->flicker_all), asked_text(width, &Asked::flicker)}));
    }
    return true;
}

bool print_moving(const Bench& bench, const Progress& progress) {
    std::vector<std::string> head{"penumbra, px"};
    for (const double speed : bench.study.speeds_px) head.push_back(fmt::format("{:g}", speed));
    head.insert(head.end(), {"worst", "asked"});
    progress.print("\n" + markdown_head(head));
    for (const double width : bench.study.widths_px) {
        const auto moving = measure_moving(bench, width);
        if (!moving) return false;
        std::vector<std::string> row{fmt::format("{:g}", width)};
        for (const Moving& m : *moving) row.push_back(fmt::format("{:.3g}", m.n_eff.median));
        const auto worst =
            std::ranges::min_element(*moving, {}, [](const Moving& m) { return m.n_eff.median; });
        row.push_back(fmt::format("{} at {:g}", text_of(worst->n_eff), worst->speed_px));
        row.push_back(asked_text(width, &Asked::moving));
        progress.print(markdown_row(row));
    }
    return true;
}

bool print_jump(const Bench& bench, const Progress& progress) {
    progress.print("\n" + markdown_head({"penumbra, px", "the sun moves the shadow by", "k90, frames",
                                         "asked", "N_eff a frame later", "left after 0, 1, ... frames"}));
    for (const double width : bench.study.widths_px)
        for (const auto& [way, told] : {std::pair{-1.0, true}, {1.0, true}, {-1.0, false}, {1.0, false}}) {
            const auto jump = measure_jump(bench, width, way * bench.study.jump_px, told);
            if (!jump) return false;
            std::string left;
            for (size_t k = 0; k < std::min<size_t>(jump->left.size(), 6); ++k)
                left += fmt::format("{}{:.3f}", k ? " " : "", jump->left[k]);
            progress.print(markdown_row(
                {fmt::format("{:g}", width),
                 fmt::format("{:g}{}", way * bench.study.jump_px, told ? "" : ", untold"), text_of(jump->k90),
                 asked_text(width, &Asked::k90), text_of(jump->n_eff), left}));
        }
    return true;
}

bool print_tilted(const Bench& bench, const Progress& progress) {
    std::vector<std::string> head{"receiver tilted by"};
    for (const double width : bench.study.tilted_widths_px)
        head.insert(head.end(), {fmt::format("{:g} px", width), "worst edge"});
    progress.print("\n" + markdown_head(head));
    for (const double tilt : bench.study.tilts_deg) {
        std::vector<std::string> row{fmt::format("{:g}", tilt)};
        for (const double width : bench.study.tilted_widths_px) {
            const auto tilted = measure_tilted(bench, width, tilt);
            if (!tilted) return false;
            row.push_back(fmt::format("{:.3g}", tilted->mean));
            row.push_back(fmt::format("{:.3g} at {:g}", tilted->worst, tilted->worst_edge_deg));
        }
        progress.print(markdown_row(row));
    }
    return true;
}

bool print_tables(const Bench& bench, const std::set<std::string>& parts, const Progress& progress) {
    return (!parts.contains("still") || print_still(bench, progress)) &&
           (!parts.contains("moving") || print_moving(bench, progress)) &&
           (!parts.contains("jump") || print_jump(bench, progress)) &&
           (!parts.contains("tilted") || print_tilted(bench, progress));
}

}  // namespace

int run_gates(const GatesArguments& arguments) {
    if (arguments.signal != "visibility") return run_radiance_gates(arguments);
    const auto nodes = open_nodes(arguments.node_folders);
    if (!nodes) return exit_wrong;
    Study study;
    if (arguments.seeds) {
        study.seeds = *arguments.seeds;
        study.tilted_seeds = std::min(study.tilted_seeds, study.seeds);
    }
    study.edge_deg = arguments.edge_deg.value_or(study.edge_deg);
    if (!arguments.widths_px.empty()) study.widths_px = arguments.widths_px;
    const std::set<std::string> all{"still", "moving", "jump", "tilted"},
        given(arguments.parts.begin(), arguments.parts.end());
    const std::set<std::string>& parts = given.empty() ? all : given;
    Diagnostics diagnostics;
    for (const std::string& part : given)
        if (!all.contains(part)) diagnostics.add({}, "--parts", part + " is of radiance: --signal specular");
    for (const double width : study.widths_px)
        if (!has_penumbra(study, width))
            diagnostics.add({}, "--widths",
                            fmt::format("no pixel's centre is within a penumbra of {} px", width));
        else if (parts.contains("jump") && !has_jump(study, width))
            diagnostics.add(
                {}, "--widths",
                fmt::format("a penumbra of {} px is too wide for the part \"jump\": no pixel changes "
                            "by more than a half",
                            width));
    const fs::path root = shipped_root();
    std::vector<std::pair<std::string, CheckedPipeline>> pipelines;
    for (const std::string& name : arguments.pipelines)
        if (const auto file = shipped_file(name, root, shipped_pipelines, diagnostics))
            if (auto pipeline = mask_pipeline(*file, *nodes, diagnostics))
                pipelines.emplace_back(file->stem().string(), std::move(*pipeline));
    std::vector<std::string> warnings;
    bool good = diagnostics.empty();
    if (good) {
        Device device({arguments.device, false});
        Progress progress("gates", static_cast<uint32_t>(pipelines.size()) * steps_of(study, parts));
        for (const auto& [name, pipeline] : pipelines) {
            progress.print(fmt::format(
                "{}{}, {}, {}x{}, edge at {:g} degrees\n\n", &name == &pipelines.front().first ? "" : "\n",
                name, counted(study.seeds, "seed"), study.size[0], study.size[1], study.edge_deg));
            good = print_tables(
                {device, *nodes, pipeline, study, [&] { progress.step(); }, diagnostics, warnings}, parts,
                progress);
            if (!good) break;
        }
    }
    print_warnings(warnings);
    if (good) return exit_good;
    return wrong(diagnostics);
}

}  // namespace penumbra
