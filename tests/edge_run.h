// SPDX-License-Identifier: MIT
// A straight shadow edge whose visibility is known in closed form, as real geometry through a whole shipped
// pipeline, and effective samples per pixel (host/metrics/metrics.h) of what comes out.
#pragma once

#include <cstring>
#include <glm/gtc/packing.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "app/session.h"
#include "host/truth/analytic.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/view_run.h"

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

class EdgeRun {
  public:
    explicit EdgeRun(const Edge& edge, const char* pipeline = "shadows", uint32_t seed = 0,
                     std::optional<uint32_t> poison = {})
        : shot_(shot_of(edge)) {
        SessionOptions options;
        options.size = edge.size;
        options.captures = {"visibility"};
        options.seed = seed;
        options.jitter = false;
        options.poison = poison;
        options.optimum = false;
        session_ = open_session(shipped_pipeline(pipeline), shot_, options);
    }

    std::vector<float> frame(uint32_t index, bool reset) {
        session_->run_frame(index, reset);
        const auto bytes = session_->view().captured("visibility");
        std::vector<float> values(bytes.size() / 2);
        for (size_t i = 0; i < values.size(); ++i) {
            uint16_t half = 0;
            std::memcpy(&half, &bytes[2 * i], 2);
            values[i] = glm::unpackHalf1x16(half);
        }
        return values;
    }
    std::vector<float> up_to(uint32_t last) {
        for (uint32_t index = 0; index < last; ++index) frame(index, index == 0);
        return frame(last, last == 0);
    }

  private:
    Shot shot_;
    std::unique_ptr<Session> session_;
};

// v(1 - v) over squared errors, of the pixels that `counted` accepts.
template <typename Counted>
double n_eff(const Edge& edge, const std::vector<float>& image, const Counted& counted) {
    const std::vector<double> truth = analytic_image(shot_of(edge), edge.last);
    double signal = 0, error = 0;
    for (int y = 0; y < int(edge.size[1]); ++y)
        for (int x = 0; x < int(edge.size[0]); ++x) {
            if (!counted(x, y)) continue;
            const size_t i = size_t(y) * edge.size[0] + size_t(x);
            const double v = truth[i];
            if (v >= 1.0 / 256 && v <= 255.0 / 256) signal += v * (1 - v);
            error += (image[i] - v) * (image[i] - v);
        }
    return signal / error;
}

// The same, `border` pixels away from the image's.
inline double n_eff_inside(const Edge& edge, const std::vector<float>& image, int border = 24) {
    return n_eff(edge, image, [&](int x, int y) {
        return x >= border && y >= border && x < int(edge.size[0]) - border && y < int(edge.size[1]) - border;
    });
}

}  // namespace penumbra::test
