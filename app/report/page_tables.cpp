// SPDX-License-Identifier: MIT
#include "app/report/page_tables.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/report/front_figures.h"
#include "app/report/html.h"
#include "app/report/plots.h"
#include "app/shell_quoted.h"

namespace penumbra::report {
namespace {

std::string contender_cell(const Results& results, size_t contender) {
    return fmt::format("<span class=\"{}\"><span class=\"key\"></span></span>{}", accent(results, contender),
                       escape(label(results.contenders[contender])));
}

std::string range(double low, double high) {
    return fmt::format(" <span class=\"range\">{}–{}</span>", number(low), number(high));
}

std::string estimate_cell(const std::optional<Estimate>& e) {
    if (!e) return "–";
    return number(e->median) + (e->low && e->high ? range(*e->low, *e->high) : "");
}

std::string n_eff_cell(const MaskMetrics& m, bool best = false) {
    if (!m.n_eff) return "–";
    const std::string value = best ? "<b class=\"best\">" + number(*m.n_eff) + "</b>" : number(*m.n_eff);
    return value + (m.n_eff_ci95 ? range((*m.n_eff_ci95)[0], (*m.n_eff_ci95)[1]) : "");
}

// The best pipeline's N_eff that many frames after a cut: brute force does not compete for bold type.
double best_after(const Results& results, size_t shot, uint32_t frames) {
    double best = 0;
    for (const Row& row : results.rows)
        if (const MaskMetrics* m = row.after(frames);
            row.shot == shot && !results.contenders[row.contender].variant() && m && m->n_eff)
            best = std::max(best, *m->n_eff);
    return best;
}

constexpr uint32_t headline_frames[] = {1, 8, 64};

std::string words(const std::vector<std::string>& list) {
    std::string out;
    for (const std::string& word : list) out += (out.empty() ? "" : " ") + word;
    return out;
}

std::string block(const std::string& text) {
    return "<pre>" + escape(text) + "</pre>\n";
}

std::string of_light(const Study& study) {
    return study.light.empty() ? "" : " --light " + shell_quoted(study.light);
}

std::string render_and_compare(const Study& study, const std::string& file, const std::string& shot,
                               std::array<uint32_t, 2> size, const std::string& frames, bool border) {
    std::string also;
    for (uint32_t seed = 2; seed <= study.seeds; ++seed) also += fmt::format(" --also out/{}", seed);
    return fmt::format(
        "for s in $(seq {}); do penumbra render {} --shot {}{} --size {}x{} --frames {} --no-jitter --seed "
        "$s "
        "--out "
        "out/$s; done\npenumbra compare out/1 out/truth{}{}\n",
        study.seeds, shell_quoted(file), shell_quoted(shot), of_light(study), size[0], size[1], frames, also,
        border ? fmt::format(" --border {}", study.analytic_border_px) : "");
}

}  // namespace

double headline_width_px(const Results& results) {
    const auto& widths = results.study.edge_widths_px;
    constexpr double wanted = 16;
    return *std::min_element(widths.begin(), widths.end(),
                             [](double a, double b) { return std::abs(a - wanted) < std::abs(b - wanted); });
}

std::string headline_table(const Results& results) {
    const bool edges = !results.study.edge_widths_px.empty();
    std::vector<Table::Column> columns{
        {"shot", false}, {"mask by", false}, {"after 1 frame"}, {"8 frames"}, {"64 frames"}};
    if (edges) columns.insert(columns.end(), {{"worst edge"}, {"at px / frame"}});
    Table table(
        "N_eff with its 95 % interval (bootstrap over 32 x 32 pixels x 32 frames); bold: the best pipeline",
        columns);
    for (size_t s = 0; s < results.shots.size(); ++s) {
        bool first = true;
        for (const Row& row : results.rows) {
            if (row.shot != s) continue;
            std::vector<std::string> cells{first ? escape(results.shots[s].name) : "",
                                           contender_cell(results, row.contender)};
            for (const uint32_t frames : headline_frames) {
                const MaskMetrics* m = row.after(frames);
                const bool best = m && m->n_eff && !results.contenders[row.contender].variant() &&
                                  *m->n_eff == best_after(results, s, frames);
                cells.push_back(m ? n_eff_cell(*m, best) : "–");
            }
            const EdgePoint* worst =
                edges ? results.worst_edge(row.contender, headline_width_px(results)) : nullptr;
            if (edges)
                cells.insert(cells.end(), {worst ? n_eff_cell(worst->metrics) : "–",
                                           worst ? results.speed_of(*worst) : "–"});
            table.row(cells, first ? "first" : "");
            first = false;
        }
    }
    return table.html();
}

std::string shot_table(const Results& results, size_t shot) {
    const bool cpu = cost_is_cpu(results);
    std::vector<Table::Column> columns{{"mask by", false},
                                       {cpu ? "mask, CPU ms" : "mask, GPU ms"},
                                       {cpu ? "frame, CPU ms" : "frame, GPU ms"},
                                       {"maps, CPU ms"},
                                       {"rays / px"},
                                       {"RMSE"},
                                       {"in penumbra"},
                                       {"N_eff"},
                                       {"x plain rays"},
                                       {"brute force's time"},
                                       {"variance"},
                                       {"bias"},
                                       {"SSIM"},
                                       {"FLIP"},
                                       {"flicker"},
                                       {"leak"},
                                       {"acne"}};
    Table table(
        "The moving shot, pooled over its judged frames. Medians with 95 % intervals. x plain rays: N_eff "
        "over "
        "that of the best plain rays, behind proofs or not, in the same time; bold: no other contender is as "
        "fast "
        "and as good. Brute force's time: how many times this time it needs for this N_eff. ~: beyond 64 "
        "rays, or "
        "faster than one. Maps: drawing the shadow maps that a pipeline reads, in no other figure.",
        columns);
    for (const Row& row : results.rows) {
        if (row.shot != shot) continue;
        const MaskMetrics& m = row.moving;
        const FrontFigure front = front_figure(results, row);
        const std::string over = over_plain_text(front);
        const std::string same =
            row.same_as ? " = " + escape(label(results.contenders[*row.same_as])) : std::string();
        table.row({contender_cell(results, row.contender) + same, estimate_cell(row.mask_cost(cpu)),
                   estimate_cell(cpu ? row.frame_cpu_ms : row.frame_ms), estimate_cell(row.maps_cpu_ms),
                   number_or_dash(row.rays_per_pixel), number_or_dash(m.rmse_all),
                   number_or_dash(m.rmse_penumbra), n_eff_cell(m),
                   front.on_front ? "<b class=\"best\">" + over + "</b>" : over, brute_force_time_text(front),
                   number_or_dash(m.n_variance), number_or_dash(m.n_bias), number_or_dash(row.ssim),
                   number_or_dash(row.flip ? std::optional(row.flip->mean) : std::nullopt),
                   number_or_dash(row.flicker), number_or_dash(m.leak), number_or_dash(m.acne)});
    }
    return table.html();
}

std::string edge_table(const Results& results) {
    Table table(
        "The worst speed per width of the penumbra",
        {{"mask by", false}, {"width, px"}, {"at rest"}, {"worst"}, {"at px / frame"}, {"lag there, px"}});
    for (size_t c = 0; c < results.contenders.size(); ++c)
        for (const double width : results.study.edge_widths_px) {
            const EdgePoint *worst = results.worst_edge(c, width), *rest = results.resting_edge(c, width);
            const bool first = width == results.study.edge_widths_px.front();
            table.row({first ? contender_cell(results, c) : "", fmt::format("{:g}", width),
                       rest ? n_eff_cell(rest->metrics) : "–", worst ? n_eff_cell(worst->metrics) : "–",
                       worst ? results.speed_of(*worst) : "–",
                       number_or_dash(worst ? worst->lag_px : std::nullopt)},
                      first ? "first" : "");
        }
    return table.html();
}

std::string passes_table(const Plan& plan) {
    Table table(
        "",
        {{"pass", false}, {"node type", false}, {"workgroups", false}, {"reads", false}, {"writes", false}});
    for (const PlanPass& pass : plan.passes) {
        if (pass.kind == PassKind::capture) continue;
        table.row({escape(pass.node), escape(pass.type),
                   pass.kind == PassKind::host ? "host"
                   : pass.indirect
                       ? "indirect"
                       : fmt::format("{} × {} × {}", pass.groups[0], pass.groups[1], pass.groups[2]),
                   escape(words(pass.reads)), escape(words(pass.writes))});
    }
    return table.html();
}

std::string commands(const Results& results) {
    const Study& study = results.study;
    const auto pipeline = std::find_if(results.contenders.rbegin(), results.contenders.rend(),
                                       [](const Contender& c) { return !c.variant(); });
    if (pipeline == results.contenders.rend() || results.shots.empty()) return {};
    std::string out;
    const ShotFacts& shot = results.shots.front();
    uint32_t first = study.moving_every - 1;
    while (first < study.settling) first += study.moving_every;
    const uint32_t last = (study.moving_frames - first - 1) / study.moving_every * study.moving_every + first;
    const std::string frames = fmt::format("{}..{}", first, last);
    out +=
        "<p>RMSE and N<sub>eff</sub> of a moving shot:</p>" +
        block(fmt::format(
                  "penumbra reference --shot {}{} --size {}x{} --frames {} --rays {} --out out/truth\n",
                  shell_quoted(shot.file), of_light(study), shot.size[0], shot.size[1], frames, study.rays) +
              render_and_compare(study, pipeline->file, shot.file, shot.size,
                                 fmt::format("{} --every {}", frames, study.moving_every), shot.exact));
    if (!study.after_cut.empty()) {
        const uint32_t still = study.after_cut.back() - 1;
        out +=
            fmt::format("<p>N<sub>eff</sub> {} frames after a cut:</p>", still + 1) +
            block(fmt::format(
                      "penumbra reference --shot {}{} --size {}x{} --frames {} --rays {} --out out/truth\n",
                      shell_quoted(shot.still_file), of_light(study), shot.size[0], shot.size[1], still,
                      study.rays) +
                  render_and_compare(study, pipeline->file, shot.still_file, shot.size, fmt::to_string(still),
                                     shot.exact));
    }
    if (study.edge_widths_px.empty()) return out;
    const std::string edge = fmt::format("shots/edge_{:g}px_{:+g}.shot.json", study.edge_widths_px.front(),
                                         study.edge_speeds_px.front());
    out += "<p>N<sub>eff</sub> behind an edge (its shot lies in this report's folder):</p>" +
           block(fmt::format("penumbra reference --shot {} --size {}x{} --frames {} --out out/truth\n", edge,
                             study.edge_size[0], study.edge_size[1], study.edge_frame) +
                 render_and_compare(study, pipeline->file, edge, study.edge_size,
                                    fmt::to_string(study.edge_frame), true));
    return out;
}

}  // namespace penumbra::report
