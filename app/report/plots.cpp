// SPDX-License-Identifier: MIT
#include "app/report/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "app/report/front_figures.h"
#include "app/report/html.h"
#include "app/report/svg.h"

namespace penumbra::report {
namespace {

constexpr double plot_width = 520, plot_height = 310;

std::optional<double> quality_of(const MaskMetrics& metrics, Quality quality) {
    return quality == Quality::rmse ? metrics.rmse_all : metrics.n_eff;
}

// Rows of a shot, in the order of the contenders.
std::vector<const Row*> rows_of(const Results& results, size_t shot) {
    std::vector<const Row*> rows;
    for (const Row& row : results.rows)
        if (row.shot == shot) rows.push_back(&row);
    return rows;
}

struct Box {
    Xy low, high;
};

bool overlap(const Box& a, const Box& b) {
    return a.low.x < b.high.x && b.low.x < a.high.x && a.low.y < b.high.y && b.low.y < a.high.y;
}

// Labels beside points, each at the first of eight places where it covers nothing that is there already;
// where there is none, the point's title and the legend must do.
class Labels {
  public:
    explicit Labels(const Frame& frame)
        : area_{frame.corner, {frame.corner.x + frame.size.x, frame.corner.y + frame.size.y}} {}

    void avoid(Xy point) { taken_.push_back({{point.x - 6, point.y - 6}, {point.x + 6, point.y + 6}}); }

    void place(Svg& svg, Xy point, const std::string& text, const std::string& style) {
        constexpr double height = 11, gap = 8;
        const double width = text_width(text);
        const Xy offsets[] = {{gap, -gap + 3},          {gap, 4},
                              {gap, gap + height - 3},  {-gap - width, 4},
                              {-width / 2, -gap},       {-width / 2, gap + height},
                              {-gap - width, -gap + 3}, {-gap - width, gap + height - 3}};
        for (const Xy& offset : offsets) {
            const Box candidate = box(point, offset, width, height);
            if (!inside(candidate) || covers(candidate)) continue;
            taken_.push_back(candidate);
            svg.text({candidate.low.x, candidate.high.y - 2}, text, "mark " + style);
            return;
        }
    }

  private:
    static Box box(Xy point, Xy offset, double width, double height) {
        const Xy corner{point.x + offset.x, point.y + offset.y - height + 2};
        return {corner, {corner.x + width, corner.y + height}};
    }
    bool inside(const Box& b) const {
        return b.low.x >= area_.low.x && b.high.x <= area_.high.x + 20 && b.low.y >= area_.low.y &&
               b.high.y <= area_.high.y;
    }
    bool covers(const Box& b) const {
        return std::any_of(taken_.begin(), taken_.end(), [&](const Box& other) { return overlap(b, other); });
    }

    Box area_;
    std::vector<Box> taken_;
};

struct Series {
    size_t contender = 0;
    std::vector<Xy> points;  // values
};

// Names at the right ends of lines, pushed apart where lines end close together.
void name_lines(Svg& svg, const Results& results, const Frame& frame, const std::vector<Series>& series) {
    constexpr double least = 12;
    std::vector<std::pair<double, size_t>> ends;  // height, contender
    for (const Series& s : series)
        if (!s.points.empty())
            ends.emplace_back(frame.at(s.points.back().x, s.points.back().y).y, s.contender);
    std::sort(ends.begin(), ends.end());
    for (size_t i = 1; i < ends.size(); ++i)
        ends[i].first = std::max(ends[i].first, ends[i - 1].first + least);
    double limit = frame.corner.y + frame.size.y + 4;
    for (auto end = ends.rbegin(); end != ends.rend(); ++end, limit -= least)
        end->first = std::min(end->first, limit);
    for (const auto& [y, contender] : ends)
        svg.text({frame.corner.x + frame.size.x + 8, y + 4}, label(results.contenders[contender]),
                 "mark " + accent(results, contender));
}

std::string series_plot(const Results& results, const std::vector<Series>& series, const Axis& x,
                        const std::string& name, const std::string& x_title, const std::string& y_title) {
    const auto x_label = [&](double value) {  // as the axis has it: its ticks may stand for something else
        for (const Tick& tick : x.ticks)
            if (tick.value == value) return tick.label;
        return fmt::format("{:g}", value);
    };
    std::vector<double> values;
    for (const Series& s : series)
        for (const Xy& p : s.points) values.push_back(p.y);
    double longest = 0;
    for (const Series& s : series)
        longest = std::max(longest, text_width(label(results.contenders[s.contender])));
    Svg svg(plot_width, plot_height, name);
    Frame frame;
    frame.size.x = plot_width - frame.corner.x - longest - 14;
    frame.x = x;
    frame.y = log_axis(values);
    frame.draw(svg, x_title, y_title);
    for (const Series& s : series) {
        const std::string style = accent(results, s.contender);
        std::vector<Xy> line;
        for (const Xy& p : s.points) line.push_back(frame.at(p.x, p.y));
        svg.polyline(line, "line " + style);
        for (const Xy& p : s.points)
            svg.circle(frame.at(p.x, p.y), 2.2, "dot " + style,
                       fmt::format("{}: {} at {}", label(results.contenders[s.contender]), number(p.y),
                                   x_label(p.x)));
    }
    name_lines(svg, results, frame, series);
    return svg.str();
}

// One line for those with the same masks.
std::vector<Series> error_series(const Results& results, size_t shot, std::vector<Judged> Row::*list) {
    std::vector<Series> all;
    for (const Row* row : rows_of(results, shot)) {
        if (row->same_as) continue;
        Series series{row->contender, {}};
        for (const Judged& judged : row->*list)
            if (judged.metrics.rmse_all && *judged.metrics.rmse_all > 0)
                series.points.push_back({static_cast<double>(judged.frame), *judged.metrics.rmse_all});
        all.push_back(std::move(series));
    }
    return all;
}

}  // namespace

std::string accent(const Results& results, size_t contender) {
    if (results.contenders[contender].variant())
        return results.contenders[contender].brute_force() ? "pb" : "pm";
    constexpr size_t colours = 12;  // of the style sheet
    return fmt::format("p{}", contender % colours);
}

std::string label(const Contender& contender) {
    if (!contender.variant()) return contender.id;
    if (!contender.brute_force()) return fmt::format("many_rays {}", contender.plain->per_pixel);
    return contender.plain->per_pixel == 1 ? "1 ray" : fmt::format("{} rays", contender.plain->per_pixel);
}

std::string cost_title(const Results& results) {
    return cost_is_cpu(results) ? "CPU ms per frame of the mask" : "GPU ms per frame of the mask";
}

std::string pareto_plot(const Results& results, size_t shot, Quality quality) {
    struct Point {
        const Row* row;
        Estimate cost;
        double value;
    };
    std::vector<Point> points;
    std::vector<double> costs, values;
    for (const Row* row : rows_of(results, shot)) {
        const auto& cost = row->mask_cost(cost_is_cpu(results));
        const auto value = quality_of(row->moving, quality);
        if (!cost || !value || !(*value > 0) || !(cost->median > 0)) continue;
        points.push_back({row, *cost, *value});
        for (const double c :
             {cost->median, cost->low.value_or(cost->median), cost->high.value_or(cost->median)})
            costs.push_back(c);
        values.push_back(*value);
    }
    const char* y_title =
        quality == Quality::rmse ? "RMSE over all receivers" : "N_eff (effective rays per pixel)";
    Svg svg(plot_width, plot_height,
            fmt::format("{} against {}, {}", y_title, cost_title(results), results.shots[shot].name));
    Frame frame;
    frame.x = log_axis(costs);
    frame.y = log_axis(values);
    frame.draw(svg, cost_title(results), y_title);
    std::vector<FrontPoint> all;
    for (const Point& p : points)
        all.push_back({p.cost.median, quality == Quality::rmse ? 1 / p.value : p.value});
    std::vector<Xy> front;
    const Front best(std::move(all));
    for (const FrontPoint& p : best.points())
        front.push_back(frame.at(p.cost, quality == Quality::rmse ? 1 / p.worth : p.worth));
    if (front.size() > 1) svg.polyline(front, "front");
    Labels labels(frame);
    for (const Point& p : points) labels.avoid(frame.at(p.cost.median, p.value));
    for (const bool proofs : {false, true}) {
        std::vector<std::pair<uint32_t, Xy>> rays;
        for (const Point& p : points)
            if (const auto& plain = results.contenders[p.row->contender].plain;
                plain && plain->proofs == proofs)
                rays.emplace_back(plain->per_pixel, frame.at(p.cost.median, p.value));
        std::ranges::sort(rays, {}, &std::pair<uint32_t, Xy>::first);
        std::vector<Xy> line;
        for (const auto& [number_of, at] : rays) line.push_back(at);
        if (line.size() > 1) svg.polyline(line, proofs ? "line pm" : "line pb");
    }
    for (const Point& p : points) {
        const Xy at = frame.at(p.cost.median, p.value);
        const std::string style = accent(results, p.row->contender);
        const std::string name = label(results.contenders[p.row->contender]);
        if (p.cost.low && p.cost.high)
            svg.line(frame.at(*p.cost.low, p.value), frame.at(*p.cost.high, p.value), "whisker " + style);
        std::string title = fmt::format("{}: {} at {} ms", name, number(p.value), number(p.cost.median));
        if (p.cost.low && p.cost.high)
            title += fmt::format(" (95 %: {} to {})", number(*p.cost.low), number(*p.cost.high));
        const FrontFigure figure = front_figure(results, *p.row);
        if (figure.over_plain) title += ", " + over_plain_text(figure) + " times plain rays at this time";
        svg.circle(at, 5, "dot " + style, title);
        labels.place(svg, at, name, style);
    }
    return svg.str();
}

std::string after_cut_plot(const Results& results, size_t shot) {
    Axis x{1, static_cast<double>(results.study.after_cut.back()), true, {}};
    for (uint32_t frame = 1; frame <= results.study.after_cut.back(); frame *= 2)
        x.ticks.push_back({static_cast<double>(frame), fmt::to_string(frame)});
    return series_plot(results, error_series(results, shot, &Row::after_cut), x,
                       fmt::format("error after a cut, {}", results.shots[shot].name),
                       "frames since the cut, nothing moves", "RMSE over all receivers");
}

std::string over_time_plot(const Results& results, size_t shot) {
    std::vector<double> frames{0};
    for (const Judged& judged : rows_of(results, shot).front()->over_time)
        frames.push_back(static_cast<double>(judged.frame));
    return series_plot(results, error_series(results, shot, &Row::over_time), linear_axis(frames, true),
                       fmt::format("error over time, {}", results.shots[shot].name),
                       "frame of the moving shot", "RMSE over all receivers");
}

std::string passes_plot(const Results& results, size_t shot) {
    const auto figure = cost_is_cpu(results) ? &PassFigure::cpu_ms : &PassFigure::ms;
    std::vector<const Row*> rows;
    double longest = 0, left = 0;
    for (const Row* row : rows_of(results, shot)) {
        if (results.contenders[row->contender].variant()) continue;
        rows.push_back(row);
        left = std::max(left, text_width(results.contenders[row->contender].id) + 20);
        double sum = 0;
        for (const PassFigure& pass : row->passes) sum += pass.*figure ? (pass.*figure)->median : 0;
        longest = std::max(longest, sum);
    }
    constexpr double bar = 26, gap = 14, width = 1080;
    const double height = static_cast<double>(rows.size()) * (bar + gap);
    Svg svg(width, height + 66, fmt::format("time per pass, {}", results.shots[shot].name));
    Frame frame{{left, 10}, {width - left - 60, height}, linear_axis({longest}, true), {}};
    frame.draw(
        svg, cost_is_cpu(results) ? "CPU ms per frame, median per pass" : "GPU ms per frame, median per pass",
        "");
    double y = 10 + gap / 2;
    for (const Row* row : rows) {
        const std::string style = accent(results, row->contender);
        svg.text({left - 10, y + 17}, results.contenders[row->contender].id, "mark " + style,
                 Svg::Anchor::end);
        double from = 0;
        size_t index = 0;
        for (const PassFigure& pass : row->passes) {
            if (!(pass.*figure)) continue;
            const double ms = (pass.*figure)->median;
            const Xy a = frame.at(from, 0), b = frame.at(from + ms, 0);
            svg.rect(
                {a.x, y}, {b.x - a.x, bar},
                fmt::format("pass {} {}", pass.pass.mask ? (index % 2 ? "odd" : "even") : "aside", style),
                fmt::format("{} / {}: {} ms{}", results.contenders[row->contender].id, pass.pass.node,
                            number(ms), pass.pass.mask ? "" : " (not part of the mask)"));
            if (b.x - a.x > text_width(pass.pass.node, 10.5) + 6)
                svg.text({(a.x + b.x) / 2, y + 17}, pass.pass.node, "on", Svg::Anchor::middle);
            from += ms;
            ++index;
        }
        svg.text({frame.at(from, 0).x + 7, y + 17}, number(from), "tick");
        y += bar + gap;
    }
    return svg.str();
}

std::string edge_plot(const Results& results, double width_px) {
    std::vector<double> speeds = results.study.edge_speeds_px;
    std::sort(speeds.begin(), speeds.end());
    // Speeds stand at even distances: they span two decades in both directions, and zero.
    Axis x{0, static_cast<double>(std::max<size_t>(speeds.size(), 2) - 1), false, {}};
    for (size_t i = 0; i < speeds.size(); ++i)
        x.ticks.push_back({static_cast<double>(i), speeds[i] == 0 ? "0" : fmt::format("{:+g}", speeds[i])});
    std::vector<Series> all;
    for (size_t c = 0; c < results.contenders.size(); ++c) {
        if (results.original(c) != c) continue;
        Series series{c, {}};
        for (const EdgePoint& point : results.edge)
            if (point.contender == c && point.width_px == width_px && point.metrics.n_eff)
                series.points.push_back(
                    {static_cast<double>(std::find(speeds.begin(), speeds.end(), point.speed_px) -
                                         speeds.begin()),
                     *point.metrics.n_eff});
        std::sort(series.points.begin(), series.points.end(), [](Xy a, Xy b) { return a.x < b.x; });
        all.push_back(std::move(series));
    }
    return series_plot(
        results, all, x,
        fmt::format("effective samples behind an edge with a penumbra of {:g} pixels", width_px),
        "speed of the edge, pixels per frame (+: the shadow grows)", "N_eff");
}

}  // namespace penumbra::report
