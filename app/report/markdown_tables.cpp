// SPDX-License-Identifier: MIT
#include "app/report/markdown_tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/counted.h"
#include "app/markdown.h"
#include "app/report/front_figures.h"
#include "app/report/html.h"
#include "app/report/plots.h"

namespace penumbra::report {
namespace {

// .31 rather than 0.31: columns are many.
std::string short_number(const std::optional<double>& value) {
    if (!value) return "-";
    const std::string text = number(*value);
    return text.starts_with("0.") ? text.substr(1) : text;
}

// "shadows, hybrid_cascades": whoever has these masks.
std::string names(const Results& results, size_t original) {
    std::string out = label(results.contenders[original]);
    for (size_t c = 0; c < results.contenders.size(); ++c)
        if (c != original && results.original(c) == original) out += ", " + label(results.contenders[c]);
    return out;
}

std::vector<std::string> shot_names(const Results& results, const std::string& corner) {
    std::vector<std::string> out{corner};
    for (const ShotFacts& shot : results.shots) out.push_back(shot.name);
    return out;
}

std::string after_cut(const Results& results) {
    std::string out = markdown_head(shot_names(results, "N_eff after 1 / 8 / 64 frames"));
    for (size_t c = 0; c < results.contenders.size(); ++c) {
        if (results.original(c) != c) continue;
        std::vector<std::string> cells{names(results, c)};
        for (size_t s = 0; s < results.shots.size(); ++s) {
            std::vector<std::string> values;
            if (const Row* row = results.row(s, c))
                for (const uint32_t frames : {1u, 8u, 64u})
                    if (const MaskMetrics* metrics = row->after(frames))
                        values.push_back(short_number(metrics->n_eff));
            // Without history a mask is as good after one frame as after many, and is judged once.
            if (values.size() == 3 && values[0] == values[1] && values[1] == values[2]) values.resize(1);
            cells.push_back(fmt::format("{}", fmt::join(values, " / ")));
        }
        out += markdown_row(cells);
    }
    return out;
}

std::string moving(const Results& results) {
    const bool cpu = cost_is_cpu(results);
    std::string out =
        markdown_head(shot_names(results, fmt::format("RMSE / N_eff / {} ms", cpu ? "CPU" : "GPU")));
    for (size_t c = 0; c < results.contenders.size(); ++c) {
        std::vector<std::string> cells{label(results.contenders[c])};
        for (size_t s = 0; s < results.shots.size(); ++s) {
            const Row* row = results.row(s, c);
            if (!row) {
                cells.push_back("-");
                continue;
            }
            const auto& cost = row->mask_cost(cpu);
            std::string cell = fmt::format("{} / {} / {}", short_number(row->moving.rmse_all),
                                           short_number(row->moving.n_eff),
                                           short_number(cost ? std::optional(cost->median) : std::nullopt));
            if (row->maps_cpu_ms) cell += " + " + short_number(row->maps_cpu_ms->median);
            cells.push_back(cell);
        }
        out += markdown_row(cells);
    }
    return out;
}

// CPU ms / N_eff / N_eff over that of the best plain rays in this time / how many times this time brute force
// needs.
std::string front(const Results& results) {
    std::string out =
        markdown_head(shot_names(results, fmt::format("{} ms / N_eff / x plain rays / brute force's time",
                                                      cost_is_cpu(results) ? "CPU" : "GPU")));
    for (size_t c = 0; c < results.contenders.size(); ++c) {
        std::vector<std::string> cells{label(results.contenders[c])};
        for (size_t s = 0; s < results.shots.size(); ++s) {
            const Row* row = results.row(s, c);
            const auto point = row ? front_point(results, *row) : std::nullopt;
            if (!point) {
                cells.push_back("-");
                continue;
            }
            const FrontFigure figure = front_figure(results, *row);
            const std::string cell = fmt::format(
                "{} / {}{}", short_number(point->cost), figure.exact ? "exact" : short_number(point->worth),
                figure.exact
                    ? ""
                    : fmt::format(" / {} / {}", over_plain_text(figure), brute_force_time_text(figure)));
            cells.push_back(figure.on_front ? "**" + cell + "**" : cell);
        }
        out += markdown_row(cells);
    }
    return out;
}

// "frame 15", "frames 11 to 63 in steps of 4"
std::string pooled_frames(const Study& study) {
    std::vector<uint32_t> frames;
    for (uint32_t f = study.moving_every - 1; f < study.moving_frames; f += study.moving_every)
        if (f >= study.settling) frames.push_back(f);
    if (frames.empty()) return "no frame";
    if (frames.size() == 1) return fmt::format("frame {}", frames.front());
    return fmt::format("frames {} to {} in steps of {}", frames.front(), frames.back(), study.moving_every);
}

std::string edge(const Results& results) {
    std::vector<std::string> columns{"N_eff at rest / worst (at px per frame)"};
    for (const double width : results.study.edge_widths_px) columns.push_back(fmt::format("{:g} px", width));
    std::string out = markdown_head(columns);
    for (size_t c = 0; c < results.contenders.size(); ++c) {
        if (results.original(c) != c) continue;
        std::vector<std::string> cells{names(results, c)};
        for (const double width : results.study.edge_widths_px) {
            const EdgePoint *worst = results.worst_edge(c, width), *rest = results.resting_edge(c, width);
            const std::string at_rest = short_number(rest ? rest->metrics.n_eff : std::nullopt);
            cells.push_back(worst ? fmt::format("{} / {} ({})", at_rest, short_number(worst->metrics.n_eff),
                                                results.speed_of(*worst))
                                  : at_rest);
        }
        out += markdown_row(cells);
    }
    return out;
}

}  // namespace

std::string markdown_tables(const Results& results) {
    const Study& study = results.study;
    std::string out = fmt::format(
        "    {}\n\n{} x {} pixels, {}, {}, penumbra {}.\n\n"
        "Speed against error of each shot as it moves, {}: cost of all that makes the mask, each pass at the "
        "least of {} in turn; effective rays per pixel, over all receivers; these over what the best plain "
        "rays have in the same time; and how many times the time brute force needs for them (~: "
        "extrapolated). Bold: no other contender is as fast and as good.\n\n{}",
        results.command, study.size[0], study.size[1], counted(study.seeds, "seed"), results.device.driver,
        PENUMBRA_VERSION, pooled_frames(study), counted(study.rounds, "round"), front(results));
    if (!study.after_cut.empty())
        out += fmt::format(
            "\nContenders in one row have the same masks to the bit.\n\nEach shot standing still:\n\n{}",
            after_cut(results));
    out += fmt::format(
        "\nEach shot as it moves; cost of the mask per frame (+ of drawing the shadow maps that it "
        "reads):\n\n{}",
        moving(results));
    if (!study.edge_widths_px.empty())
        out += fmt::format(
            "\nBehind a straight edge, {} frames after the start, by the width of its penumbra:\n\n{}",
            study.edge_frame + 1, edge(results));
    return out;
}

}  // namespace penumbra::report
