// SPDX-License-Identifier: MIT
// penumbra gates --signal specular or diffuse: Markdown tables beside what is asked (docs/reflections.md).
#include <fmt/format.h>

#include <set>

#include "app/counted.h"
#include "app/gates/radiance_gates.h"
#include "app/markdown.h"
#include "app/node_folders.h"
#include "app/progress.h"
#include "app/shipped_files.h"
#include "app/signal_pipeline.h"
#include "app/wrong.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using namespace gates;

// Of a table whose columns are the classes of roughness and then some more.
std::string head_of(const std::string& what, const std::vector<std::string>& more) {
    std::vector<std::string> cells{what, "to .05", "to .15", "to .3", "to .5", "to 1"};
    cells.insert(cells.end(), more.begin(), more.end());
    return markdown_head(cells);
}

std::string text_of(const std::optional<double>& value) {
    return value ? fmt::format("{:.3g}", *value) : "-";
}

std::string percent(double share) {
    return fmt::format("{:.1f} %", 100 * share);
}

// Whole lines, after what was being done.
void print(const Doing& doing, const std::string& lines) {
    doing.clear();
    fmt::print("{}", lines);
    std::fflush(stdout);
}

// A diffuse lobe has no roughness: all of it is the last class.
std::string row_of(const std::string& name, const RadianceErrorSums& sums) {
    std::vector<std::string> cells{name};
    for (size_t c = 0; c < roughness_classes; ++c) cells.push_back(text_of(sums.n_eff(c)));
    cells.insert(cells.end(), {text_of(sums.n_eff()), sums.bias() ? percent(*sums.bias()) : "-",
                               fmt::to_string(sums.fireflies), text_of(sums.flicker())});
    return markdown_row(cells);
}

bool print_tables(const RadianceBench& bench, const std::set<std::string>& parts, const Doing& doing) {
    if (parts.contains("furnace")) {
        const auto furnace = measure_furnace(bench);
        if (!furnace) return false;
        std::vector<std::string> row{""};
        for (const double off : *furnace) row.push_back(fmt::format("{:.2g}", off));
        row.emplace_back("<= .001");
        print(doing,
              head_of("white furnace, farthest from 1 by roughness", {"asked"}) + markdown_row(row) + "\n");
    }
    if (parts.contains("still") || parts.contains("moving"))
        print(doing, head_of("N_eff by roughness", {"all", "bias, asked <= 1 %", "fireflies", "flicker"}));
    if (parts.contains("still")) {
        const auto still = measure_still(bench);
        if (!still) return false;
        for (size_t i = 0; i < still->size(); ++i)
            print(doing, row_of(fmt::format("standing, after {}", bench.study.after[i]), (*still)[i]));
    }
    if (parts.contains("moving")) {
        const auto moving = measure_moving(bench);
        if (!moving) return false;
        print(doing, row_of(fmt::format("in motion, after {}", bench.study.moving_frames), *moving));
    }
    if (parts.contains("lag")) {
        const auto left = measure_lamp_off(bench);
        if (!left) return false;
        std::vector<std::string> head{"frames since the lamp went off"}, row{"of its light is left"};
        for (const uint32_t after : bench.study.after_off) head.push_back(fmt::to_string(after));
        for (const double share : *left) row.push_back(percent(share));
        head.emplace_back("asked");
        row.emplace_back("<= 10 % after 12");
        print(doing, "\n" + markdown_head(head) + markdown_row(row));
    }
    return true;
}

}  // namespace

int run_radiance_gates(const GatesArguments& arguments) {
    const auto nodes = open_nodes(arguments.node_folders);
    if (!nodes) return exit_wrong;
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const std::set<std::string> all{"furnace", "still", "moving", "lag"},
        given(arguments.parts.begin(), arguments.parts.end());
    for (const std::string& part : given)
        if (!all.contains(part)) diagnostics.add({}, "--parts", part + " is of visibility, not of radiance");
    if (arguments.edge_deg) diagnostics.add({}, "--edge-deg", "is of visibility, not of radiance");
    if (!arguments.widths_px.empty()) diagnostics.add({}, "--widths", "is of visibility, not of radiance");
    RadianceStudy study;
    study.seeds = arguments.seeds.value_or(study.seeds);
    std::vector<CheckedPipeline> pipelines;
    for (const std::string& name : arguments.pipelines) {
        const auto file = shipped_file(name, shipped_root(), shipped_pipelines, diagnostics);
        auto pipeline =
            file ? signal_pipeline(*file, arguments.signal, {}, *nodes, diagnostics) : std::nullopt;
        if (pipeline) pipelines.push_back(std::move(*pipeline));
    }
    bool good = diagnostics.empty();
    if (good) {
        Device device({arguments.device, false});
        const RadianceScenes scenes;
        Doing doing;
        for (const CheckedPipeline& pipeline : pipelines) {
            print(doing, fmt::format("{}{}, {}, {}, {}x{}\n\n", &pipeline == &pipelines.front() ? "" : "\n",
                                     pipeline.name, arguments.signal, counted(study.seeds, "seed"),
                                     study.size[0], study.size[1]));
            const auto told = [&](const std::string& what, double share) { doing(what, share); };
            good = print_tables(
                {device, *nodes, pipeline, arguments.signal, study, scenes, diagnostics, warnings, told},
                given.empty() ? all : given, doing);
            if (!good) break;
        }
    }
    print_warnings(warnings);
    if (good) return exit_good;
    return wrong(diagnostics);
}

}  // namespace penumbra
