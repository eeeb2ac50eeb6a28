// SPDX-License-Identifier: MIT
#include "app/beam_figure.h"

#include <fmt/format.h>

#include "app/counted.h"
#include "app/report/svg.h"

namespace penumbra {
namespace {

using report::Svg;
using report::Xy;

constexpr double side = 300, gap = 20, legend_height = 110;
constexpr double radius = side / 2 / tile_beam_reach;

constexpr const char* style_sheet =
    "text { font: 13px system-ui, \"Liberation Sans\", sans-serif; fill: #1c2024; }\n"
    ".head { font-weight: 600; }\n"
    ".soft { fill: #5b636c; font-size: 12px; }\n"
    ".ground { fill: #f6f7f8; }\n"
    ".beam { fill: #fff1c2; }\n"
    ".rim { fill: none; stroke: #b0540e; stroke-width: 1.6; }\n"
    ".triangle { fill: #2b4a7a; fill-opacity: .22; stroke: #2b4a7a; stroke-width: .7; stroke-opacity: .6; }\n"
    ".patch { fill: #2b4a7a; fill-opacity: .75; stroke: #ffffff; stroke-width: 1; }\n"
    ".border { stroke: #d01c2a; stroke-width: 2.4; }\n"
    ".axis { fill: #1d2733; }\n";

std::string word_of(TileVerdict verdict) {
    return verdict == TileVerdict::lit ? "lit" : verdict == TileVerdict::dark ? "dark" : "open";
}

std::string reason_of(const TileBeam& beam) {
    if (beam.verdict == TileVerdict::lit) return "nothing in it";
    if (beam.verdict == TileVerdict::dark) return "closed off by " + counted(beam.patch(), "triangle");
    return beam.nearest_border() < 1 ? "a border in it" : "not told within the steps it has";
}

void draw(Svg& svg, const TileBeam& beam, Xy corner) {
    const Xy middle{corner.x + side / 2, corner.y + side / 2};
    const auto place = [&](const glm::dvec2& p) {
        return Xy{middle.x + radius * p.x, middle.y - radius * p.y};
    };
    svg.rect(corner, {side, side}, "ground");
    svg.circle(middle, radius, "beam");
    for (const bool patch : {false, true})
        for (const BeamTriangle& triangle : beam.triangles) {
            if (triangle.in_patch != patch) continue;
            std::string path;
            for (const glm::dvec2& p : triangle.outline) {
                const Xy at = place(p);
                path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : " L", at.x, at.y);
            }
            svg.path(path + " Z", patch ? "patch" : "triangle", fmt::format("triangle {}", triangle.index));
        }
    // Behind a patch borders are no way out.
    if (beam.verdict != TileVerdict::dark)
        for (const BeamEdge& edge : beam.borders) svg.line(place(edge.from), place(edge.to), "border");
    svg.circle(middle, radius, "rim");
    svg.circle(middle, 3, "axis");
    svg.text({corner.x + 2, corner.y + side + 20}, word_of(beam.verdict) + ": " + reason_of(beam), "head");
    svg.text({corner.x + 2, corner.y + side + 38},
             fmt::format("tile {},{}, {}", beam.tile[0], beam.tile[1], counted(beam.pixels, "pixel")),
             "soft");
}

}  // namespace

std::string beam_summary(const TileBeam& beam) {
    return fmt::format("tile {},{} ({}): {}, {}", beam.tile[0], beam.tile[1], counted(beam.pixels, "pixel"),
                       word_of(beam.verdict), reason_of(beam));
}

std::string beam_figure(std::span<const TileBeam> beams, const CoverageCaption& caption) {
    const std::string where =
        fmt::format("{}, frame {}, {}x{}", caption.shot, caption.frame, caption.size[0], caption.size[1]);
    std::string label = where;
    for (const TileBeam& beam : beams) label += ". " + beam_summary(beam);
    const double count = static_cast<double>(beams.size());
    Svg svg(count * side + (count - 1) * gap, side + legend_height, label);
    for (size_t i = 0; i < beams.size(); ++i) draw(svg, beams[i], {static_cast<double>(i) * (side + gap), 0});
    svg.text({2, side + 64}, where, "head");
    svg.text({2, side + 84},
             "Along the beam: circle, its rim; blue, triangles; dark blue, the patch that closes it;",
             "soft");
    svg.text({2, side + 101}, "red, borders, where a surface ends or folds back.", "soft");
    return svg.file(style_sheet);
}

}  // namespace penumbra
