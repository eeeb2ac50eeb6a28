// SPDX-License-Identifier: MIT
#include "app/cost_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>

#include "app/report/svg.h"

namespace penumbra {
namespace {

using Json = nlohmann::json;
using report::Svg;
using report::Xy;

constexpr double width = 860, bar = 30, gap = 12, top = 44, bottom = 46, right = 64;
constexpr double pass_text = 11;

constexpr const char* style_sheet =
    "text { font: 12px system-ui, \"Liberation Sans\", sans-serif; fill: #1c2024; }\n"
    ".head { font-weight: 600; }\n"
    ".tick, .title { fill: #5b636c; }\n"
    ".grid { stroke: #d9dde1; } .axis { stroke: #5b636c; }\n"
    ".on { fill: #ffffff; font-size: 11px; } .off { fill: #5b636c; font-size: 11px; }\n"
    ".c0 { fill: #2462c8; } .c1 { fill: #b0540e; } .c2 { fill: #0a7f6f; }\n"
    ".c3 { fill: #c02a72; } .c4 { fill: #7a4fd0; } .c5 { fill: #4f7a0f; }\n"
    ".c6 { fill: #9a6a00; } .c7 { fill: #0d7ea8; } .c8 { fill: #a3423b; }\n"
    ".c9 { fill: #5b5fae; } .c10 { fill: #2f8f3a; } .c11 { fill: #8c2fa8; }\n"
    ".c12 { fill: #3a4a5a; } .c13 { fill: #c8641e; } .c14 { fill: #b03030; }\n"
    ".c15 { fill: #00695c; } .c16 { fill: #6b5b00; } .c17 { fill: #a03c8a; }\n"
    ".pass { stroke: #ffffff; stroke-width: .8; }\n";
constexpr size_t colours = 18;

// Node types in the order in which they first occur.
std::vector<std::string> pass_types(const std::vector<PipelineCosts>& costs) {
    std::vector<std::string> types;
    for (const PipelineCosts& c : costs)
        for (const PassCost& pass : c.passes)
            if (std::find(types.begin(), types.end(), pass.type) == types.end()) types.push_back(pass.type);
    return types;
}

// Where the colours' names stand, in rows as wide as the figure: a short pass has no room for its own.
std::vector<Xy> legend_places(const std::vector<std::string>& types) {
    constexpr double first = 16, row = 18;
    std::vector<Xy> places;
    Xy at{first, 0};
    for (const std::string& type : types) {
        const double size = report::text_width(type, pass_text) + 32;
        if (at.x + size > width && at.x > first) at = {first, at.y + row};
        places.push_back(at);
        at.x += size;
    }
    return places;
}

std::string milliseconds(double ms) {
    return fmt::format("{:.{}f}", ms, ms < 1 ? 2 : ms < 10 ? 1 : 0);
}

// What all bars share is said once, in the title.
template <class Get>
bool all_alike(const std::vector<PipelineCosts>& costs, Get&& get) {
    return std::ranges::all_of(costs, [&](const PipelineCosts& c) { return get(c) == get(costs.front()); });
}

std::string size_text(const PipelineCosts& c) {
    return fmt::format("{}x{}", c.size[0], c.size[1]);
}

struct Names {
    std::string title;
    std::vector<std::string> bars;
};

Names names_of(const std::vector<PipelineCosts>& costs) {
    Names names;
    for (const PipelineCosts& c : costs) names.bars.push_back(c.pipeline);
    const auto place = [&](auto&& get) {
        if (all_alike(costs, get))
            names.title += (names.title.empty() ? "" : ", ") + get(costs.front());
        else
            for (size_t i = 0; i < costs.size(); ++i) names.bars[i] += ", " + get(costs[i]);
    };
    place([](const PipelineCosts& c) { return c.shot; });
    place(size_text);
    place([](const PipelineCosts& c) { return c.device; });
    return names;
}

}  // namespace

double PipelineCosts::total() const {
    return std::accumulate(passes.begin(), passes.end(), 0.0,
                           [](double sum, const PassCost& p) { return sum + p.ms; });
}

std::optional<PipelineCosts> read_costs(const std::string& file, Diagnostics& diagnostics) {
    const auto wrong = [&](const std::string& why) {
        diagnostics.add({file, 0, 0}, "", why);
        return std::nullopt;
    };
    std::ifstream stream(file);
    if (!stream) return wrong("no such file");
    if (std::error_code none; std::filesystem::is_directory(file, none)) return wrong("is a folder");
    const Json report = Json::parse(stream, nullptr, false);
    if (report.is_discarded()) return wrong("is no JSON");
    try {
        PipelineCosts costs{report.at("pipeline"),
                            report.at("shot"),
                            report.at("device").at("name"),
                            report.at("size"),
                            {},
                            false};
        for (const Json& pass : report.at("passes")) {
            if (pass.at("type") == "capture" || pass.at("type") == "validate") continue;
            const Json& cpu = pass.at("cpu_ms").at("median");  // on devices of the class cpu alone
            costs.by_cpu = !cpu.is_null();
            const Json& ms = costs.by_cpu ? cpu : pass.at("ms").at("median");
            if (ms.is_null()) return wrong("has no times of passes: the device has no timestamps");
            costs.passes.push_back({pass.at("node"), pass.at("type"), ms});
        }
        if (!(costs.total() > 0)) return wrong("has no pass that took any time");
        return costs;
    } catch (const Json::exception&) {
        return wrong("is no report.json of penumbra render");
    }
}

std::string cost_figure(const std::vector<PipelineCosts>& costs) {
    const Names names = names_of(costs);
    const std::vector<std::string> types = pass_types(costs);
    double left = 0, longest = 0;
    for (size_t i = 0; i < costs.size(); ++i) {
        left = std::max(left, report::text_width(names.bars[i], 13) + 28);
        longest = std::max(longest, costs[i].total());
    }
    const double height = static_cast<double>(costs.size()) * (bar + gap) + gap;
    const std::vector<Xy> legend = legend_places(types);
    const double legend_height = legend.empty() ? 0 : legend.back().y;
    const bool by_cpu = std::ranges::all_of(costs, &PipelineCosts::by_cpu);
    const std::string unit = by_cpu                                                ? "CPU ms"
                             : std::ranges::none_of(costs, &PipelineCosts::by_cpu) ? "GPU ms"
                                                                                   : "CPU or GPU ms";
    Svg svg(width, top + height + bottom + 24 + legend_height, unit + " per pass, " + names.title);
    svg.text({16, 24}, names.title, "head");
    const report::Frame frame{
        {left, top}, {width - left - right, height}, report::linear_axis({longest}, true), {}};
    frame.draw(svg, unit + " per frame, median per pass", "");
    double y = top + gap;
    for (size_t i = 0; i < costs.size(); ++i, y += bar + gap) {
        svg.text({left - 10, y + 20}, names.bars[i], "head", Svg::Anchor::end);
        double from = 0;
        for (const PassCost& pass : costs[i].passes) {
            const double x = frame.at(from, 0).x, size = frame.at(from + pass.ms, 0).x - x;
            const auto colour =
                static_cast<size_t>(std::find(types.begin(), types.end(), pass.type) - types.begin());
            svg.rect({x, y}, {size, bar}, fmt::format("pass c{}", colour % colours),
                     fmt::format("{}, {}: {} ms", names.bars[i], pass.node, milliseconds(pass.ms)));
            const std::string label = fmt::format("{} {}", pass.node, milliseconds(pass.ms));
            if (size > report::text_width(label, pass_text) + 4)
                svg.text({x + size / 2, y + 19}, label, "on", Svg::Anchor::middle);
            else if (size > report::text_width(pass.node, pass_text) + 4)
                svg.text({x + size / 2, y + 19}, pass.node, "on", Svg::Anchor::middle);
            from += pass.ms;
        }
        svg.text({frame.at(from, 0).x + 7, y + 20}, milliseconds(from), "tick");
    }
    for (size_t i = 0; i < types.size(); ++i) {
        const Xy at{legend[i].x, top + height + bottom + 10 + legend[i].y};
        svg.rect({at.x, at.y - 9}, {10, 10}, fmt::format("c{}", i % colours));
        svg.text({at.x + 14, at.y}, types[i], "off");
    }
    return svg.file(style_sheet);
}

}  // namespace penumbra
