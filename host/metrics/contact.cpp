// SPDX-License-Identifier: MIT
// From points along the line, a walk in the shadow's direction looks at the nearest pixel's value every
// quarter of a pixel.
#include "host/metrics/contact.h"

#include <cmath>

namespace penumbra {
namespace {

constexpr double step_px = 0.25, spacing_px = 0.5, farthest_px = 64;

// Distance to the first pixel darker than a half; absent where the walk leaves the measured pixels before
// that.
std::optional<double> gap_px(const ComparedFrame& frame, std::span<const float> image,
                             const std::array<double, 2>& start, const std::array<double, 2>& away) {
    for (double t = step_px / 2; t < farthest_px; t += step_px) {
        const double x = std::floor(start[0] + t * away[0]), y = std::floor(start[1] + t * away[1]);
        if (x < 0 || y < 0 || x >= frame.width || y >= frame.height) return std::nullopt;
        const size_t p = static_cast<size_t>(y) * frame.width + static_cast<size_t>(x);
        if (frame.counted[p] && !(image[p] >= 0.5f) && std::isfinite(image[p])) return t;
    }
    return std::nullopt;
}

}  // namespace

std::optional<double> peter_panning_px(const ComparedFrame& frame, const ContactLine& line) {
    check_sizes(frame, "peter_panning_px");
    const double dx = line.to[0] - line.from[0], dy = line.to[1] - line.from[1];
    const auto starts = 1 + static_cast<int>(std::hypot(dx, dy) / spacing_px);
    double sum = 0;
    size_t walks = 0;
    for (int i = 0; i < starts; ++i) {
        const double t = starts > 1 ? static_cast<double>(i) / (starts - 1) : 0;
        const std::array start{line.from[0] + t * dx, line.from[1] + t * dy};
        const auto expected = gap_px(frame, frame.truth, start, line.away);
        if (!expected) continue;
        for (const std::span<const float> seed : frame.seeds) {
            // No shadow at all is the longest gap that is looked for.
            sum += gap_px(frame, seed, start, line.away).value_or(farthest_px) - *expected;
            ++walks;
        }
    }
    if (!walks) return std::nullopt;
    return sum / static_cast<double>(walks);
}

}  // namespace penumbra
