// SPDX-License-Identifier: MIT
#include "host/metrics/front.h"

#include <algorithm>
#include <cmath>

namespace penumbra {
namespace {

// The value of `out` where `in` is `at`, on the line through points that rise in both.
std::optional<Front::Reading> read(const std::vector<FrontPoint>& points, double FrontPoint::*in,
                                   double FrontPoint::*out, double at) {
    if (!(std::isfinite(at) && at > 0)) return std::nullopt;
    const auto own = std::ranges::find(points, at, in);
    if (own != points.end()) return Front::Reading{(*own).*out, false};
    if (points.size() < 2) return std::nullopt;
    const auto above = std::ranges::upper_bound(points, at, {}, in);
    const auto second = std::clamp(above, points.begin() + 1, points.end() - 1);
    const FrontPoint &a = *(second - 1), &b = *second;
    const double t = std::log(at / (a.*in)) / std::log((b.*in) / (a.*in));
    return Front::Reading{a.*out * std::pow((b.*out) / (a.*out), t),
                          above == points.begin() || above == points.end()};
}

}  // namespace

bool beats(const FrontPoint& a, const FrontPoint& b) {
    return a.cost <= b.cost && a.worth >= b.worth && (a.cost < b.cost || a.worth > b.worth);
}

Front::Front(std::vector<FrontPoint> points) {
    std::erase_if(points,
                  [](const FrontPoint& p) { return !(std::isfinite(p.cost) && p.cost > 0 && p.worth > 0); });
    std::ranges::sort(points, [](const FrontPoint& a, const FrontPoint& b) {
        return a.cost < b.cost || (a.cost == b.cost && a.worth > b.worth);
    });
    for (const FrontPoint& p : points) {
        if (std::isinf(p.worth)) {
            exact_from_ = p.cost;
            break;  // nothing dearer is better
        }
        if (points_.empty() || p.worth > points_.back().worth) points_.push_back(p);
    }
}

std::optional<Front::Reading> Front::worth_at(double cost) const {
    if (exact_from_ && cost >= *exact_from_) return Reading{INFINITY, false};
    return read(points_, &FrontPoint::cost, &FrontPoint::worth, cost);
}

std::optional<Front::Reading> Front::cost_of(double worth) const {
    const auto on_line = read(points_, &FrontPoint::worth, &FrontPoint::cost, worth);
    const bool too_dear = exact_from_ && worth > 0 && (!on_line || on_line->value >= *exact_from_);
    return too_dear ? Reading{*exact_from_, false} : on_line;
}

}  // namespace penumbra
