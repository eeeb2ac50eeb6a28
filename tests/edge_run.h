// SPDX-License-Identifier: MIT
// A straight shadow edge whose visibility is known in closed form, as real geometry through a whole shipped
// pipeline, and effective samples per pixel (host/metrics/metrics.h) of what comes out.
#pragma once

#include <vector>

#include "host/truth/analytic.h"
#include "tests/shot_run.h"

namespace penumbra::test {

struct Edge {
    double width_px = 8;
    double speed_px = 0;
    uint32_t last = 63;    // frame that is looked at; the penumbra is in the middle of the image then
    double offset_px = 0;  // from there
    std::array<uint32_t, 2> size{192, 112};
    double edge_deg = 17;
};

inline Shot shot_of(const Edge& edge) {
    Shot shot;
    shot.analytic = AnalyticScene{edge.width_px, edge.edge_deg, edge.speed_px,
                                  edge.offset_px - edge.speed_px * edge.last};
    shot.size = edge.size;
    shot.frames = edge.last + 1;
    shot.sun = {{0, {0.3, 0.2, 1}}};
    add_analytic_motion(shot);
    return shot;
}

inline std::vector<float> truth_of(const Edge& edge) {
    return analytic_truth(shot_of(edge), edge.last).visibility;
}

// Pixels that lie `border` away from the image's.
inline auto inside_of(const Edge& edge, size_t border = 24) {
    return [edge, border](size_t i) {
        const size_t x = i % edge.size[0], y = i / edge.size[0];
        return x >= border && y >= border && x + border < edge.size[0] && y + border < edge.size[1];
    };
}

inline double n_eff_inside(const Edge& edge, const std::vector<float>& image) {
    return n_eff(image, truth_of(edge), inside_of(edge));
}

}  // namespace penumbra::test
