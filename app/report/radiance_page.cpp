// SPDX-License-Identifier: MIT
#include "app/report/radiance_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/markdown.h"
#include "app/metrics_json.h"
#include "app/or_null.h"
#include "app/radiance_json.h"
#include "app/report/assets.h"
#include "app/report/html.h"
#include "app/report/images.h"
#include "app/report/svg.h"

namespace penumbra::report {
namespace {

using OrderedJson = nlohmann::ordered_json;

std::string reading_text(const std::optional<Front::Reading>& reading) {
    return reading ? (reading->extrapolated ? "~" : "") + number(reading->value) : "–";
}

std::string percent(const std::optional<double>& share) {
    return share ? fmt::format("{:.1f} %", 100 * *share) : "–";
}

std::string classes(const RadianceErrorSums& sums) {
    std::string out;
    for (size_t c = 0; c < roughness_classes; ++c) out += (c ? " / " : "") + number_or_dash(sums.n_eff(c));
    return out + "; " + number_or_dash(sums.n_eff());
}

std::vector<const RadianceRow*> rows_of(const RadianceResults& results, const std::string& shot) {
    std::vector<const RadianceRow*> rows;
    for (const RadianceRow& row : results.rows)
        if (row.shot == shot) rows.push_back(&row);
    return rows;
}

std::vector<std::string> heads(const RadianceResults& results) {
    return {"contender", results.cpu ? "CPU ms" : "ms",
            "N_eff",     "x brute force",
            "relMSE",    "bias",
            "FLIP, lit", "flicker",
            "fireflies", "not finite"};
}

std::vector<std::string> figures(const RadianceResults& results, const RadianceRow& row) {
    return {results.contenders[row.contender].id,
            number_or_dash(row.cost_ms),
            number_or_dash(row.moving.n_eff()),
            reading_text(over_brute_force(results, row)),
            number_or_dash(row.moving.relmse()),
            percent(row.moving.bias()),
            number(row.flip.mean),
            number_or_dash(row.still.back().flicker()),
            std::to_string(row.moving.fireflies),
            std::to_string(row.moving.nonfinite)};
}

std::string style_of(const RadianceResults& results, const RadianceRow& row) {
    return results.contenders[row.contender].rays ? "pb" : fmt::format("p{}", row.contender % 12);
}

// N_eff in motion against the cost of the signal; brute force is a dashed line.
std::string front_plot(const RadianceResults& results, const std::string& shot) {
    std::vector<double> costs, worths;
    for (const RadianceRow* row : rows_of(results, shot))
        if (const auto point = front_point(*row)) {
            costs.push_back(point->cost);
            worths.push_back(point->worth);
        }
    Svg svg(520, 310, "effective rays against cost, " + shot);
    Frame frame;
    frame.x = log_axis(costs);
    frame.y = log_axis(worths);
    frame.draw(svg, results.cpu ? "CPU milliseconds of the signal" : "milliseconds of the signal",
               "effective rays per pixel");
    std::vector<Xy> line;
    for (const RadianceRow* row : rows_of(results, shot)) {
        const auto point = front_point(*row);
        if (!point) continue;
        const Xy at = frame.at(point->cost, point->worth);
        const RadianceContender& contender = results.contenders[row->contender];
        svg.circle(at, contender.rays ? 2.5 : 4, "dot " + style_of(results, *row),
                   fmt::format("{}: {} in {} ms", contender.id, number(point->worth), number(point->cost)));
        if (contender.rays)
            line.push_back(at);
        else
            svg.text({at.x + 7, at.y - 6}, contender.id, "mark " + style_of(results, *row));
    }
    svg.polyline(line, "line dashed pb");
    return svg.str();
}

std::string picture(const std::filesystem::path& folder, const std::string& file, const std::string& name) {
    return fmt::format("<figure><img alt=\"{0}\" src=\"{1}\"><figcaption>{0}</figcaption></figure>",
                       escape(name), data_uri(folder / file));
}

std::string shot_section(const RadianceResults& results, const std::string& shot,
                         const std::filesystem::path& folder) {
    std::vector<Table::Column> columns;
    for (const std::string& head : heads(results)) columns.push_back({head, !columns.empty()});
    Table speed(fmt::format("In motion, frame {}", results.study.moving_frame), columns);
    columns = {{"contender", false}};
    for (const uint32_t after : results.study.after)
        columns.push_back({fmt::format("standing, after {}", after), false});
    columns.push_back({fmt::format("in motion, after {}", results.study.moving_frame + 1), false});
    Table rough("N_eff by roughness up to .05 / .15 / .3 / .5 / 1; over all", columns);
    std::string pictures = picture(folder, "images/" + shot + ".reference.png", "reference");
    for (const RadianceRow* row : rows_of(results, shot)) {
        const RadianceContender& contender = results.contenders[row->contender];
        std::vector<std::string> cells = figures(results, *row);
        cells[0] = fmt::format("<span class=\"key {}\"></span>{}", style_of(results, *row), escape(cells[0]));
        speed.row(cells);
        std::vector<std::string> by_class{cells[0]};
        for (const RadianceErrorSums& sums : row->still) by_class.push_back(classes(sums));
        by_class.push_back(classes(row->moving));
        rough.row(by_class);
        if (!contender.rays || *contender.rays == 1) pictures += picture(folder, row->image, contender.id);
    }
    return fmt::format(
        "<section id=\"{0}\"><h2>{0}</h2><figure>{1}</figure>{2}{3}<h3>Lit pictures in which all but this "
        "signal "
        "is true</h3><div class=\"plots\">{4}</div></section>",
        escape(shot), front_plot(results, shot), speed.html(), rough.html(), pictures);
}

}  // namespace

OrderedJson to_json(const RadianceResults& results) {
    const RadianceStudy& study = results.study;
    OrderedJson json = {{"command", results.command},
                        {"signal", results.signal},
                        {"device", results.device},
                        {"cost_is_cpu", results.cpu},
                        {"size", study.size},
                        {"seeds", study.seeds},
                        {"rays", study.rays},
                        {"moving_frame", study.moving_frame},
                        {"results", OrderedJson::array()}};
    for (const RadianceRow& row : results.rows) {
        const RadianceContender& contender = results.contenders[row.contender];
        OrderedJson one = {{"shot", row.shot},
                           {"contender", contender.id},
                           {"file", contender.file},
                           {"settings", contender.settings},
                           {"cost_ms", or_null(row.cost_ms)},
                           {"moving", radiance_json(row.moving)},
                           {"still", OrderedJson::array()}};
        for (size_t i = 0; i < row.still.size(); ++i) {
            OrderedJson still = {{"after", study.after[i]}};
            still.update(radiance_json(row.still[i]));
            one["still"].push_back(std::move(still));
        }
        const auto over = over_brute_force(results, row);
        one["over_brute_force"] = over ? OrderedJson(over->value) : OrderedJson();
        one["flip"] = flip_json(row.flip);
        one["lit_relmse"] = row.lit_relmse;
        one["image"] = row.image;
        json["results"].push_back(std::move(one));
    }
    return json;
}

std::string markdown_tables(const RadianceResults& results) {
    std::string out;
    for (const std::string& shot : results.shots) {
        out += "## " + shot + "\n" + markdown_head(heads(results));
        for (const RadianceRow* row : rows_of(results, shot)) out += markdown_row(figures(results, *row));
        std::vector<std::string> columns{"N_eff by roughness"};
        for (const uint32_t after : results.study.after) columns.push_back(fmt::format("after {}", after));
        columns.push_back(fmt::format("in motion, after {}", results.study.moving_frame + 1));
        out += "\n" + markdown_head(columns);
        for (const RadianceRow* row : rows_of(results, shot)) {
            std::vector<std::string> cells{results.contenders[row->contender].id};
            for (const RadianceErrorSums& sums : row->still)
                cells.push_back(classes(sums) + ", bias " + percent(sums.bias()));
            cells.push_back(classes(row->moving) + ", bias " + percent(row->moving.bias()));
            out += markdown_row(cells);
        }
        out += "\n";
    }
    return out;
}

std::string radiance_page(const RadianceResults& results, const std::filesystem::path& folder) {
    std::string shots;
    for (const std::string& shot : results.shots) shots += shot_section(results, shot, folder);
    return fill(assets::radiance_html,
                {{"style", assets::style_css},
                 {"signal", results.signal},
                 {"device", escape(results.device)},
                 {"size", fmt::format("{}x{}", results.study.size[0], results.study.size[1])},
                 {"seeds", std::to_string(results.study.seeds)},
                 {"rays", std::to_string(results.study.rays)},
                 {"shots", shots},
                 {"command", escape(results.command)}});
}

}  // namespace penumbra::report
