// SPDX-License-Identifier: MIT
#include "app/gather_figure.h"

#include <fmt/format.h>

#include <cmath>

#include "app/report/svg.h"

namespace penumbra {
namespace {

using report::Svg;
using report::Xy;

constexpr double side = 440, gap = 40, legend_height = 96;
constexpr double radius = 125;  // of the sun on the right; neighbours' rays lie around it

constexpr const char* style_sheet =
    "text { font: 13px system-ui, \"Liberation Sans\", sans-serif; fill: #1c2024; }\n"
    ".head { font-weight: 600; }\n"
    ".soft { fill: #5b636c; font-size: 12px; }\n"
    ".lit { fill: #fff1c2; stroke: #d9dde1; stroke-width: .6; }\n"
    ".dark { fill: #44505f; stroke: #d9dde1; stroke-width: .6; }\n"
    ".other { fill: #ffffff; stroke: #d9dde1; stroke-width: .6; }\n"
    ".disc { fill: none; stroke: #9aa3ac; stroke-width: .7; }\n"
    ".asking { fill: none; stroke: #d01c2a; stroke-width: 2.4; }\n"
    ".sun { fill: #fffaf0; stroke: #d01c2a; stroke-width: 2; }\n"
    ".lit-ray { fill: #ffb000; stroke: #a86a00; stroke-width: .8; }\n"
    ".dark-ray { fill: #1d2733; stroke: #1d2733; stroke-width: .8; }\n"
    ".outside { fill-opacity: .28; stroke-opacity: .28; }\n";

std::string ray_style(const GatheredRay& ray) {
    return ray.lit ? "lit-ray" : "dark-ray";
}

void draw_neighbourhood(Svg& svg, const Gathered& gathered) {
    constexpr int across = 2 * RayGatherer::reach + 1;
    constexpr double cell = side / across;
    for (const GatheredRay& ray : gathered.rays) {
        const Xy corner{(ray.offset[0] + RayGatherer::reach) * cell,
                        (ray.offset[1] + RayGatherer::reach) * cell};
        const Xy centre{corner.x + cell / 2, corner.y + cell / 2};
        svg.rect(corner, {cell, cell}, !ray.on_surface ? "other" : ray.lit ? "lit" : "dark");
        if (!ray.on_surface) continue;
        svg.circle(centre, 0.4 * cell, "disc");
        svg.circle({centre.x + 0.4 * cell * ray.own[0], centre.y - 0.4 * cell * ray.own[1]}, 3,
                   ray_style(ray));
    }
    const double corner = RayGatherer::reach * cell;
    svg.rect({corner, corner}, {cell, cell}, "asking");
}

void draw_sun(Svg& svg, const Gathered& gathered) {
    constexpr Xy middle{side + gap + side / 2, side / 2};
    svg.circle(middle, radius, "sun");
    for (const GatheredRay& ray : gathered.rays) {
        const double x = radius * ray.seen[0], y = radius * ray.seen[1];
        if (!ray.on_surface || std::abs(x) > side / 2 || std::abs(y) > side / 2) continue;
        svg.circle({middle.x + x, middle.y - y}, 4, ray_style(ray) + (ray.counts() ? "" : " outside"));
    }
}

}  // namespace

std::string gather_summary(const Gathered& gathered) {
    size_t lit = 0;
    for (const GatheredRay& ray : gathered.rays) lit += ray.counts() && ray.lit;
    return fmt::format(
        "{} of {} rays are tests of this pixel's sun, {} of them lit: visibility {:.3f}; blockers {:.3g} m "
        "away",
        gathered.counted(), gathered.rays.size(), lit, gathered.visibility(), gathered.distance_m);
}

std::string gather_figure(const Gathered& gathered, const CoverageCaption& caption) {
    const std::string where =
        fmt::format("{}, frame {}, {}x{}, pixel {},{}", caption.shot, caption.frame, caption.size[0],
                    caption.size[1], caption.pixel[0], caption.pixel[1]);
    const std::string summary = gather_summary(gathered);
    Svg svg(2 * side + gap, side + legend_height, where + ". " + summary);
    draw_neighbourhood(svg, gathered);
    draw_sun(svg, gathered);
    svg.text({4, side + 22}, where, "head");
    svg.text({4, side + 42}, summary);
    svg.text({4, side + 62},
             "Left: the pixels around, one ray each; the dot is the point of the sun's disc that it went to.",
             "soft");
    svg.text(
        {4, side + 80},
        "Right: the same rays as tests of the middle pixel's sun (circle). Pale: beside it, no test of it.",
        "soft");
    return svg.file(style_sheet);
}

}  // namespace penumbra
