// SPDX-License-Identifier: MIT
#include "app/bench/bench_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "app/bench/native_pass.h"
#include "app/device_json.h"
#include "app/markdown.h"
#include "app/or_null.h"

namespace penumbra::bench {
namespace {

using OrderedJson = nlohmann::ordered_json;
using Size = std::array<uint32_t, 2>;

OrderedJson json_of(const Rounds& rounds) {
    return {{"least", or_null(rounds.least())}, {"median", or_null(rounds.median())}};
}

double pixels(const Scene& scene) {
    return double(scene.size[0]) * scene.size[1];
}

std::optional<double> ns_per_pixel(const Rounds& ms, const Scene& scene) {
    const auto least = ms.least();
    return least ? std::optional(*least * 1e6 / pixels(scene)) : std::nullopt;
}

std::optional<double> native_passes(const Rounds& cpu_ms, const Scene& scene) {
    const auto least = cpu_ms.least();
    return least ? std::optional(*least / *scene.native_ms.least()) : std::nullopt;
}

std::optional<double> of_last_light(const Figures& f, const Scene& scene) {
    return f.last_light_bytes ? std::optional(double(*f.last_light_bytes) / pixels(scene)) : std::nullopt;
}

OrderedJson memory_of(const Figures& f, const Scene& scene) {
    const MemoryReport& m = f.memory;
    return {{"heap_bytes", m.heap_bytes},
            {"live_bound_bytes", m.live_bound_bytes},
            {"optimum_bytes", m.optimum_bytes ? OrderedJson(*m.optimum_bytes) : OrderedJson()},
            {"unaliased_bytes", m.unaliased_bytes},
            {"persistent_bytes", m.persistent_bytes},
            {"bytes_per_pixel", double(m.heap_bytes) / pixels(scene)},
            {"last_light_bytes_per_pixel", or_null(of_last_light(f, scene))}};
}

OrderedJson json_of(const Figures& f, const Bench& bench, const Scene& scene) {
    OrderedJson passes = OrderedJson::array();
    for (const PassFigures& pass : f.passes)
        passes.push_back({{"node", pass.node},
                          {"type", pass.type},
                          {"mask", pass.mask},
                          {"cpu_ms", json_of(pass.cpu_ms)},
                          {"ms", json_of(pass.ms)},
                          {"cpu_ns_per_pixel", or_null(ns_per_pixel(pass.cpu_ms, scene))},
                          {"native_passes", or_null(native_passes(pass.cpu_ms, scene))},
                          {"bound_bytes", pass.bytes},
                          {"gb_per_s", or_null(pass.gb_per_s())}});
    const Contender& contender = bench.contenders[f.contender];
    return {{"id", contender.id},
            {"file", contender.file},
            {"passes", passes},
            {"sum",
             {{"cpu_ms", json_of(f.pass_cpu_ms)},
              {"ms", json_of(f.pass_ms)},
              {"native_passes", or_null(native_passes(f.pass_cpu_ms, scene))}}},
            {"frame",
             {{"cpu_ms", json_of(f.frame_cpu_ms)},
              {"wall_ms", json_of(f.wall_ms)},
              {"cpu_ns_per_pixel", or_null(ns_per_pixel(f.frame_cpu_ms, scene))},
              {"native_passes", or_null(native_passes(f.frame_cpu_ms, scene))},
              {"record_us_per_pass", json_of(f.record_us)}}},
            {"compile_ms", json_of(f.compile_ms)},
            {"program_ms", f.program_ms},
            {"first_frame_ms", f.first_frame_ms},
            {"frame_0_ms", or_null(f.frame_0_ms)},
            {"memory", memory_of(f, scene)}};
}

std::string number(const std::optional<double>& value) {
    if (!value) return "-";
    return *value >= 99.95   ? fmt::format("{:.0f}", *value)
           : *value >= 9.995 ? fmt::format("{:.1f}", *value)
                             : fmt::format("{:.2f}", *value);
}

std::string mebibytes(std::optional<uint64_t> bytes) {
    return bytes ? fmt::format("{:.2f}", double(*bytes) / (1 << 20)) : "-";
}

// A line per row, a cell per scene.
struct Table {
    std::vector<const Scene*> scenes;
    size_t contender;
    std::string text;

    using Cell = std::function<std::string(const Figures&, const Scene&)>;
    void head(const std::string& what) {
        std::vector<std::string> cells{what};
        for (const Scene* scene : scenes) cells.push_back(scene->shot);
        text += markdown_head(cells);
    }
    void row(const std::string& what, const Cell& cell) {
        std::vector<std::string> cells{what};
        for (const Scene* scene : scenes) cells.push_back(cell(scene->contenders[contender], *scene));
        text += markdown_row(cells);
    }
};

// Passes of all scenes, in the order of the first that has them: what a scene does not need it does not run.
std::vector<std::string> pass_names(const Table& table) {
    std::vector<std::string> names;
    for (const Scene* scene : table.scenes) {
        auto place = names.begin();
        for (const PassFigures& pass : scene->contenders[table.contender].passes) {
            const auto found = std::find(names.begin(), names.end(), pass.node);
            place = (found == names.end() ? names.insert(place, pass.node) : found) + 1;
        }
    }
    return names;
}

// CPU device: native passes first, which carry over to other machines.
std::string costs(const Rounds& cpu_ms, const Scene& scene) {
    return fmt::format("{} np, {} / {} ms", number(native_passes(cpu_ms, scene)), number(cpu_ms.least()),
                       number(cpu_ms.median()));
}

std::string costs(const PassFigures& pass, const Scene& scene, bool cpu) {
    if (cpu) return costs(pass.cpu_ms, scene);
    return fmt::format("{} / {} ms, {} GB/s", number(pass.ms.least()), number(pass.ms.median()),
                       number(pass.gb_per_s()));
}

void pass_rows(Table& table, bool cpu) {
    table.head("pass");
    for (const std::string& name : pass_names(table))
        table.row(name, [&](const Figures& f, const Scene& scene) {
            const auto pass = std::ranges::find(f.passes, name, &PassFigures::node);
            return pass == f.passes.end() ? std::string("-") : costs(*pass, scene, cpu);
        });
    if (cpu) {
        table.row("sum", [](const Figures& f, const Scene& s) { return costs(f.pass_cpu_ms, s); });
        table.row("frame as one submission",
                  [](const Figures& f, const Scene& s) { return costs(f.frame_cpu_ms, s); });
    } else {
        table.row("sum", [](const Figures& f, const Scene&) {
            return number(f.pass_ms.least()) + " / " + number(f.pass_ms.median()) + " ms";
        });
    }
}

void frame_rows(Table& table, bool cpu, bool still) {
    table.text += "\n";
    table.head("whole frame");
    if (cpu)
        table.row("CPU ns per pixel",
                  [](const Figures& f, const Scene& s) { return number(ns_per_pixel(f.frame_cpu_ms, s)); });
    table.row("wall ms", [](const Figures& f, const Scene&) {
        return number(f.wall_ms.least()) + " / " + number(f.wall_ms.median());
    });
    table.row("recording, CPU us per pass",
              [](const Figures& f, const Scene&) { return number(f.record_us.least()); });
    table.row("pipeline to plan / plan to device objects, ms", [](const Figures& f, const Scene&) {
        return number(f.compile_ms.least()) + " / " + number(f.program_ms);
    });
    table.row("first frame / frame 0 again, wall ms", [](const Figures& f, const Scene&) {
        return number(f.first_frame_ms) + " / " + number(f.frame_0_ms);
    });
    table.row("heap / live bound / optimum, MiB", [](const Figures& f, const Scene&) {
        return mebibytes(f.memory.heap_bytes) + " / " + mebibytes(f.memory.live_bound_bytes) + " / " +
               mebibytes(f.memory.optimum_bytes);
    });
    table.row("heap, bytes per pixel", [](const Figures& f, const Scene& s) {
        return number(double(f.memory.heap_bytes) / pixels(s));
    });
    if (std::ranges::any_of(table.scenes, [&](const Scene* s) {
            return s->contenders[table.contender].last_light_bytes.has_value();
        }))
        table.row("of which for the last of the lights",
                  [](const Figures& f, const Scene& s) { return number(of_last_light(f, s)); });
    if (still)
        table.row("settles after, frames", [](const Figures& f, const Scene&) {
            return (f.settles ? fmt::format("{}", *f.settles) : "never") +
                   (f.held == 0         ? ""
                    : f.held == f.timed ? "; held"
                                        : fmt::format("; {} of {} held", f.held, f.timed));
        });
}

const char* standing(const Options& options) {
    if (options.still) return " standing still";
    return options.still_camera ? " before a still camera" : "";
}

}  // namespace

OrderedJson to_json(const Bench& bench) {
    OrderedJson scenes = OrderedJson::array();
    for (const Scene& scene : bench.scenes) {
        OrderedJson pipelines = OrderedJson::array();
        for (const Figures& f : scene.contenders) pipelines.push_back(json_of(f, bench, scene));
        scenes.push_back({{"shot", scene.shot},
                          {"size", scene.size},
                          {"native_pass_ms", json_of(scene.native_ms)},
                          {"pipelines", pipelines}});
    }
    return {{"penumbra", 1},
            {"command", bench.command},
            {"device", device_json(bench.device)},
            {"native_pass", has_avx2() ? "avx2" : "plain"},
            {"frames", bench.options.frames},
            {"rounds", bench.options.rounds},
            {"still", bench.options.still},
            {"still_camera", bench.options.still_camera},
            {"scenes", scenes}};
}

std::string tables(const Bench& bench) {
    const bool cpu = bench.device.is_cpu;
    std::string text;
    std::vector<Size> sizes;
    for (const Scene& scene : bench.scenes)
        if (std::ranges::find(sizes, scene.size) == sizes.end()) sizes.push_back(scene.size);
    for (size_t c = 0; c < bench.contenders.size(); ++c)
        for (const Size& size : sizes) {
            Table table{{}, c, {}};
            for (const Scene& scene : bench.scenes)
                if (scene.size == size) table.scenes.push_back(&scene);
            const Scene& first = *table.scenes.front();
            text += fmt::format(
                "{}**{}**, {}x{}, frames {} to {}{}, {}; least / median of {} rounds{}\n\n",
                text.empty() ? "" : "\n", bench.contenders[c].id, size[0], size[1], bench.options.frames[0],
                bench.options.frames[1], standing(bench.options), bench.device.driver, bench.options.rounds,
                cpu ? fmt::format("; a native pass ({}) takes {} ms", has_avx2() ? "AVX2" : "a plain loop",
                                  number(first.native_ms.least()))
                    : "");
            pass_rows(table, cpu);
            frame_rows(table, cpu, bench.options.still);
            text += table.text;
        }
    return text;
}

}  // namespace penumbra::bench
