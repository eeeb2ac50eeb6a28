// SPDX-License-Identifier: MIT
#include "app/report/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/report/html.h"

namespace penumbra::report {
namespace {

std::string class_of(std::string_view style) {
    return style.empty() ? "" : fmt::format(" class=\"{}\"", style);
}

std::string tick_label(double value) {
    const double size = std::abs(value);
    if (size >= 1e6) return fmt::format("{:g}M", value / 1e6);
    if (size >= 1e4) return fmt::format("{:g}k", value / 1e3);
    return fmt::format("{:g}", value);
}

}  // namespace

Svg::Svg(double width, double height, std::string_view label) {
    head_ = fmt::format(
        "<svg viewBox=\"0 0 {:.0f} {:.0f}\" width=\"{:.0f}\" height=\"{:.0f}\" role=\"img\" "
        "aria-label=\"{}\">\n",
        width, height, width, height, escape(label));
}

void Svg::close(std::string_view element, std::string_view title) {
    body_ += title.empty() ? "/>\n" : fmt::format("><title>{}</title></{}>\n", escape(title), element);
}

void Svg::line(Xy a, Xy b, std::string_view style) {
    body_ += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"{}/>\n", a.x, a.y, b.x,
                         b.y, class_of(style));
}

void Svg::polyline(const std::vector<Xy>& points, std::string_view style) {
    std::string list;
    for (const Xy& p : points) list += fmt::format("{}{:.1f},{:.1f}", list.empty() ? "" : " ", p.x, p.y);
    body_ += fmt::format("<polyline points=\"{}\"{}/>\n", list, class_of(style));
}

void Svg::path(std::string_view commands, std::string_view style, std::string_view title) {
    body_ += fmt::format("<path d=\"{}\"{}", commands, class_of(style));
    close("path", title);
}

void Svg::rect(Xy corner, Xy size, std::string_view style, std::string_view title, double radius) {
    body_ += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"{}{}", corner.x,
                         corner.y, std::max(size.x, 0.0), std::max(size.y, 0.0),
                         radius > 0 ? fmt::format(" rx=\"{:g}\"", radius) : "", class_of(style));
    close("rect", title);
}

void Svg::circle(Xy centre, double radius, std::string_view style, std::string_view title) {
    body_ += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:g}\"{}", centre.x, centre.y, radius,
                         class_of(style));
    close("circle", title);
}

void Svg::text(Xy at, std::string_view text, std::string_view style, Anchor anchor, double turn_deg) {
    constexpr const char* names[] = {"start", "middle", "end"};
    const std::string turn =
        turn_deg == 0 ? "" : fmt::format(" transform=\"rotate({:g} {:.1f} {:.1f})\"", turn_deg, at.x, at.y);
    body_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}{}>{}</text>\n", at.x, at.y,
                         names[static_cast<size_t>(anchor)], class_of(style), turn, escape(text));
}

std::string Svg::str() const {
    return head_ + body_ + "</svg>\n";
}

std::string Svg::file(std::string_view style_sheet) const {
    constexpr std::string_view element = "<svg ";
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" {}<style>\n{}</style>\n"
        "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{}</svg>\n",
        std::string_view(head_).substr(element.size()), style_sheet, body_);
}

double text_width(std::string_view text, double pixels) {
    return 0.56 * pixels * static_cast<double>(text.size());
}

double Axis::at(double value) const {
    if (log) return (std::log(value) - std::log(low)) / (std::log(high) - std::log(low));
    return (value - low) / (high - low);
}

Axis linear_axis(const std::vector<double>& values, bool from_zero) {
    constexpr double wanted_steps = 5;
    double low = from_zero ? 0 : INFINITY, high = from_zero ? 0 : -INFINITY;
    for (const double value : values) {
        if (!std::isfinite(value)) continue;
        low = std::min(low, value);
        high = std::max(high, value);
    }
    if (!(low <= high)) low = high = 0;  // no values
    if (low == high) high = low + 1;
    const double raw = (high - low) / wanted_steps, decade = std::pow(10, std::floor(std::log10(raw)));
    const double step = decade * (raw / decade <= 1 ? 1 : raw / decade <= 2 ? 2 : raw / decade <= 5 ? 5 : 10);
    const double first = std::floor(low / step + 1e-9), last = std::ceil(high / step - 1e-9);
    Axis axis{first * step, last * step, false, {}};
    // From whole numbers of steps, so that no rounding error adds up to a label of many digits.
    for (double i = first; i <= last; ++i) axis.ticks.push_back({i * step, tick_label(i * step)});
    return axis;
}

Axis log_axis(const std::vector<double>& values) {
    double low = INFINITY, high = 0;
    for (const double value : values) {
        if (!(std::isfinite(value) && value > 0)) continue;
        low = std::min(low, value);
        high = std::max(high, value);
    }
    if (!(low <= high)) low = high = 1;  // no values
    const auto all = [](int first_decade, int last_decade) {
        std::vector<double> candidates;
        for (int decade = first_decade; decade <= last_decade; ++decade)
            for (const int digit : {1, 2, 5})
                candidates.push_back(decade < 0 ? digit / std::pow(10, -decade)
                                                : digit * std::pow(10, decade));
        return candidates;
    };
    const std::vector<double> candidates = all(static_cast<int>(std::floor(std::log10(low))) - 1,
                                               static_cast<int>(std::ceil(std::log10(high))) + 1);
    constexpr double slack = 1e-9;
    const auto above =
        std::find_if(candidates.begin(), candidates.end(), [&](double c) { return c >= high * (1 - slack); });
    const auto below = std::find_if(candidates.rbegin(), candidates.rend(),
                                    [&](double c) { return c <= low * (1 + slack); });
    Axis axis{*below, *above, true, {}};
    if (axis.low == axis.high) axis.high = *(above + 1);
    constexpr double many_decades = 3;
    const bool decades_only = std::log10(axis.high / axis.low) > many_decades;
    for (const double c : candidates) {
        const double digits = std::log10(c);
        const bool decade = std::abs(digits - std::round(digits)) < slack;
        if (c < axis.low * (1 - slack) || c > axis.high * (1 + slack) || (decades_only && !decade)) continue;
        axis.ticks.push_back({c, tick_label(c)});
    }
    return axis;
}

Xy Frame::at(double x_value, double y_value) const {
    return {corner.x + size.x * x.at(x_value), corner.y + size.y * (1 - y.at(y_value))};
}

void Frame::draw(Svg& svg, std::string_view x_title, std::string_view y_title) const {
    const double bottom = corner.y + size.y;
    for (const Tick& tick : x.ticks) {
        const double at = corner.x + size.x * x.at(tick.value);
        svg.line({at, corner.y}, {at, bottom}, "grid");
        svg.text({at, bottom + 16}, tick.label, "tick", Svg::Anchor::middle);
    }
    for (const Tick& tick : y.ticks) {
        const double at = corner.y + size.y * (1 - y.at(tick.value));
        svg.line({corner.x, at}, {corner.x + size.x, at}, "grid");
        svg.text({corner.x - 7, at + 4}, tick.label, "tick", Svg::Anchor::end);
    }
    svg.line({corner.x, bottom}, {corner.x + size.x, bottom}, "axis");
    svg.line({corner.x, corner.y}, {corner.x, bottom}, "axis");
    svg.text({corner.x + size.x / 2, bottom + 34}, x_title, "title", Svg::Anchor::middle);
    svg.text({13, corner.y + size.y / 2}, y_title, "title", Svg::Anchor::middle, -90);
}

}  // namespace penumbra::report
