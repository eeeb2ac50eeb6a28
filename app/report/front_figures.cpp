// SPDX-License-Identifier: MIT
#include "app/report/front_figures.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "app/report/html.h"

namespace penumbra::report {
namespace {

std::vector<FrontPoint> points_of(const Results& results, size_t shot,
                                  const std::function<bool(const Contender&)>& wanted) {
    std::vector<FrontPoint> points;
    for (const Row& row : results.rows)
        if (row.shot == shot && wanted(results.contenders[row.contender]))
            if (const auto point = front_point(results, row)) points.push_back(*point);
    return points;
}

std::string reading_text(bool exact, const std::optional<Front::Reading>& reading) {
    if (exact) return "exact";
    if (!reading) return "–";
    return (reading->extrapolated ? "~" : "") + number(reading->value);
}

}  // namespace

bool cost_is_cpu(const Results& results) {
    return results.device.is_cpu;
}

std::optional<FrontPoint> front_point(const Results& results, const Row& row) {
    const auto& cost = row.mask_cost(cost_is_cpu(results));
    const MaskMetrics& m = row.moving;
    if (!cost || !(cost->median > 0) || m.penumbra == 0) return std::nullopt;
    if (m.n_eff && !(*m.n_eff > 0)) return std::nullopt;
    return FrontPoint{cost->median, m.n_eff.value_or(INFINITY)};
}

FrontFigure front_figure(const Results& results, const Row& row) {
    FrontFigure figure;
    const auto own = front_point(results, row);
    if (!own) return figure;
    figure.exact = std::isinf(own->worth);
    figure.on_front =
        std::ranges::none_of(points_of(results, row.shot, [](const Contender&) { return true; }),
                             [&](const FrontPoint& other) { return beats(other, *own); });
    const Front plain(points_of(results, row.shot, [](const Contender& c) { return c.plain.has_value(); }));
    const Front brute_force(points_of(results, row.shot, [](const Contender& c) { return c.brute_force(); }));
    if (figure.exact) return figure;  // no number of rays is enough
    if (auto worth = plain.worth_at(own->cost)) {
        worth->value = own->worth / worth->value;
        figure.over_plain = worth;
    }
    if (auto cost = brute_force.cost_of(own->worth)) {
        cost->value /= own->cost;
        figure.brute_force_time = cost;
    }
    return figure;
}

std::string over_plain_text(const FrontFigure& figure) {
    return reading_text(figure.exact, figure.over_plain);
}

std::string brute_force_time_text(const FrontFigure& figure) {
    return reading_text(figure.exact, figure.brute_force_time);
}

}  // namespace penumbra::report
