// SPDX-License-Identifier: MIT
#include "app/coverage_figure.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "app/counted.h"
#include "app/report/svg.h"

namespace penumbra {
namespace {

using report::Svg;
using report::Xy;

constexpr double side = 560, radius = 190, middle = side / 2, legend_height = 92;

constexpr const char* style_sheet =
    "text { font: 13px system-ui, \"Liberation Sans\", sans-serif; fill: #1c2024; }\n"
    ".head { font-weight: 600; }\n"
    ".soft { fill: #5b636c; font-size: 12px; }\n"
    ".sun { fill: #fff6d6; }\n"
    ".rim { fill: none; stroke: #b0540e; stroke-width: 1.6; }\n"
    ".triangle { fill: #2b4a7a; fill-opacity: .1; }\n"
    ".edge { fill: none; stroke: #2b4a7a; stroke-width: 1; stroke-opacity: .75; }\n"
    ".holes { stroke-dasharray: 4 2.5; }\n"
    ".surface { fill: #7b838b; fill-opacity: .25; }\n"
    ".surface-edge { stroke: #5b636c; stroke-width: 1.2; stroke-dasharray: 7 4; }\n"
    ".hidden { fill: #1d2733; }\n"
    ".visible { fill: #ffb000; stroke: #a86a00; stroke-width: .8; }\n";

// A convex polygon across the light; `rim` says that the edge from a corner to the next is the figure's
// border, not a triangle's.
struct Corner {
    glm::dvec2 at;
    bool rim;
};
using Outline = std::vector<Corner>;

Outline border() {
    constexpr int corners = 120;
    Outline polygon;
    for (int i = 0; i < corners; ++i) {
        const double angle = 2 * std::numbers::pi * i / corners;
        polygon.push_back({coverage_figure_reach * glm::dvec2(std::cos(angle), std::sin(angle)), true});
    }
    return polygon;
}

// What of a convex polygon lies where line . (x, y, 1) >= 0 (Sutherland and Hodgman).
Outline clipped(const Outline& polygon, const glm::dvec3& line) {
    Outline out;
    const auto height = [&](const glm::dvec2& p) { return line.x * p.x + line.y * p.y + line.z; };
    for (size_t i = 0; i < polygon.size(); ++i) {
        const Corner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double ha = height(a.at), hb = height(b.at);
        if (ha >= 0) out.push_back(a);
        if ((ha >= 0) != (hb >= 0))
            out.push_back({a.at + (b.at - a.at) * (ha / (ha - hb)), ha >= 0 ? false : a.rim});
    }
    return out;
}

// From units of the sun's radius, in the pixel's turned axes, to the figure: up is the world's, seen towards
// the sun.
class Placement {
  public:
    explicit Placement(const CoverageReceiver& receiver) {
        const glm::dvec3 forward = receiver.axes[2];
        const glm::dvec3 world_up = std::abs(forward.y) < 0.999 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, -1);
        const glm::dvec3 right = glm::normalize(glm::cross(forward, world_up)),
                         up = glm::cross(right, forward);
        x_ = {glm::dot(receiver.axes[0], right), glm::dot(receiver.axes[0], up)};
        y_ = {glm::dot(receiver.axes[1], right), glm::dot(receiver.axes[1], up)};
    }

    Xy operator()(const glm::dvec2& p) const {
        const glm::dvec2 at = p.x * x_ + p.y * y_;
        return {middle + radius * at.x, middle - radius * at.y};
    }

  private:
    glm::dvec2 x_{}, y_{};
};

std::string path_of(const Outline& polygon, const Placement& place) {
    std::string commands;
    for (const Corner& corner : polygon) {
        const Xy p = place(corner.at);
        commands += fmt::format("{}{:.1f} {:.1f}", commands.empty() ? "M" : " L", p.x, p.y);
    }
    return commands + " Z";
}

void draw_edges(Svg& svg, const Outline& polygon, const Placement& place, const std::string& style) {
    for (size_t i = 0; i < polygon.size(); ++i)
        if (!polygon[i].rim)
            svg.line(place(polygon[i].at), place(polygon[(i + 1) % polygon.size()].at), style);
}

// `line` is across the light in tangents; the figure's unit is the tangent of the sun's radius.
glm::dvec3 in_radii(const glm::dvec3& line, double angular_radius) {
    const double tangent = std::tan(angular_radius);
    return {line.x * tangent, line.y * tangent, line.z};
}

Outline outline(const SeenTriangle& triangle, double angular_radius) {
    Outline polygon = border();
    for (const glm::dvec3& line : triangle.lines) polygon = clipped(polygon, in_radii(line, angular_radius));
    return polygon;
}

void draw_legend(Svg& svg, bool surface, bool holes) {
    double y = side + 58;
    svg.circle({26, y - 4}, 4.5, "visible");
    svg.text({38, y}, "visible sample", "soft");
    svg.circle({156, y - 4}, 4.5, "hidden");
    svg.text({168, y}, "hidden sample", "soft");
    svg.rect({282, y - 10}, {14, 11}, "triangle");
    svg.rect({282, y - 10}, {14, 11}, "edge");
    svg.text({302, y}, "triangle", "soft");
    svg.circle({378, y - 4}, 6, "rim");
    svg.text({390, y}, "rim of the sun", "soft");
    y += 20;
    double x = 20;
    if (holes) {
        svg.line({x, y - 4}, {x + 14, y - 4}, "edge holes");
        svg.text({x + 20, y}, "triangle with holes", "soft");
        x += 150;
    }
    if (surface) {
        svg.line({x, y - 4}, {x + 14, y - 4}, "surface-edge");
        svg.text({x + 20, y}, "the pixel's own surface", "soft");
    }
}

}  // namespace

std::string coverage_summary(const PixelCoverage& coverage) {
    const uint32_t hiding = coverage.hiding();
    const std::string surface = coverage.by_surface.any() ? " and the pixel's own surface" : "";
    return fmt::format("{}{} {} {} of {} samples: visibility {:.3f}", counted(hiding, "triangle"), surface,
                       hiding == 1 && surface.empty() ? "hides" : "hide", coverage.hidden.count(),
                       coverage.samples, coverage.visibility());
}

std::string coverage_figure(const SampledSun& sun, const CoverageReceiver& receiver,
                            const PixelCoverage& coverage, const CoverageCaption& caption) {
    const std::string where =
        fmt::format("{}, frame {}, {}x{}, pixel {},{}", caption.shot, caption.frame, caption.size[0],
                    caption.size[1], caption.pixel[0], caption.pixel[1]);
    const std::string summary = coverage_summary(coverage);
    Svg svg(side, side + legend_height, where + ". " + summary);
    const Placement place(receiver);
    svg.circle({middle, middle}, radius, "sun");

    const Outline below = clipped(border(), -in_radii(coverage.surface_line, receiver.angular_radius));
    if (!below.empty()) {
        svg.path(path_of(below, place), "surface", "the pixel's own surface");
        draw_edges(svg, below, place, "surface-edge");
    }
    bool holes = false;
    std::vector<std::pair<const SeenTriangle*, Outline>> outlines;
    for (const SeenTriangle& triangle : coverage.triangles)
        if (Outline polygon = outline(triangle, receiver.angular_radius); polygon.size() > 2)
            outlines.emplace_back(&triangle, std::move(polygon));
    for (const auto& [triangle, polygon] : outlines)
        svg.path(
            path_of(polygon, place), "triangle",
            fmt::format("triangle {}: {}", triangle->index, counted(triangle->hidden.count(), "sample")));
    for (const auto& [triangle, polygon] : outlines) {
        draw_edges(svg, polygon, place, triangle->alpha ? "edge holes" : "edge");
        holes |= triangle->alpha;
    }
    svg.circle({middle, middle}, radius, "rim");
    const double dot =
        0.3 * radius * std::sqrt(std::numbers::pi / sun.count());  // 0.3 of the samples' spacing
    for (uint32_t i = 0; i < sun.count(); ++i) {
        const auto [x, y] = sun.place(i, receiver.angular_radius);
        svg.circle(place({x, y}), dot, coverage.hidden[i] ? "hidden" : "visible");
    }
    svg.text({20, side + 10}, where, "head");
    svg.text({20, side + 30}, summary);
    draw_legend(svg, !below.empty(), holes);
    return svg.file(style_sheet);
}

}  // namespace penumbra
