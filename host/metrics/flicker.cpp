// SPDX-License-Identifier: MIT
// A step is d = (v - W v') - (v* - W v'*), W the bilinear warp by the true motion. Only pixels whose
// previous position lies on the same surface are looked at.
#include "host/metrics/flicker.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host/metrics/bilinear.h"

namespace penumbra {
namespace {

// Motion is stored in half floats: what they round away of a still pixel is no motion.
constexpr double smallest_motion_px = 1.0 / 256;
// Share of the depth by which the same surface may differ; half floats keep the depth's change to 1 / 2048.
constexpr double same_surface = 0.01;

double snapped(double pixels) {
    const double nearest = std::round(pixels);
    return std::abs(pixels - nearest) < smallest_motion_px ? nearest : pixels;
}

double finite_or_worst(float value, float truth) {
    return std::isfinite(value) ? static_cast<double>(value) : truth > 0.5f ? 0 : 1;
}

bool same_place(const TimeStep& step, const BilinearTaps& taps, size_t pixel) {
    const double expected =
        static_cast<double>(step.depth[pixel]) + static_cast<double>(step.depth_change[pixel]);
    for (size_t i = 0; i < 4; ++i) {
        if (taps.weights[i] == 0) continue;
        const size_t q = taps.pixels[i];
        if (!step.before.counted[q]) return false;
        if (!(std::abs(static_cast<double>(step.depth_before[q]) - expected) <= same_surface * expected))
            return false;
    }
    return true;
}

void check(const TimeStep& step, const FlickerSums& sums) {
    check_sizes(step.now, "add_flicker");
    check_sizes(step.before, "add_flicker");
    const size_t pixels = step.now.pixels();
    bool fits = step.before.width == step.now.width && step.before.height == step.now.height &&
                step.before.seeds.size() == step.now.seeds.size() &&
                (sums.pixel_steps.empty() || sums.pixel_steps.size() == pixels);
    for (const auto& image : {step.motion_x, step.motion_y, step.depth_change, step.depth, step.depth_before})
        fits = fits && image.size() == pixels;
    if (!fits) throw std::invalid_argument("add_flicker: images of different sizes");
}

}  // namespace

void add_flicker(const TimeStep& step, FlickerSums& sums) {
    check(step, sums);
    const uint32_t width = step.now.width, height = step.now.height;
    sums.pixel_squares.resize(step.now.pixels());
    sums.pixel_steps.resize(step.now.pixels());
    for (size_t p = 0; p < step.now.pixels(); ++p) {
        if (!step.now.counted[p]) continue;
        const double x = static_cast<double>(p % width) + 0.5, y = static_cast<double>(p / width) + 0.5;
        const auto taps =
            bilinear_taps(x + snapped(static_cast<double>(step.motion_x[p]) * width),
                          y + snapped(static_cast<double>(step.motion_y[p]) * height), width, height);
        if (!taps || !same_place(step, *taps, p)) continue;
        const double truth = static_cast<double>(step.now.truth[p]) - taps->of(step.before.truth);
        for (size_t s = 0; s < step.now.seeds.size(); ++s) {
            double before = 0;
            for (size_t i = 0; i < 4; ++i) {
                const size_t q = taps->pixels[i];
                before += taps->weights[i] * finite_or_worst(step.before.seeds[s][q], step.before.truth[q]);
            }
            const double d = finite_or_worst(step.now.seeds[s][p], step.now.truth[p]) - before - truth;
            sums.squares += d * d;
            ++sums.pixels;
            sums.pixel_squares[p] += d * d;
            ++sums.pixel_steps[p];
        }
    }
}

std::optional<double> FlickerSums::rms() const {
    if (pixels == 0) return std::nullopt;
    return std::sqrt(squares / static_cast<double>(pixels));
}

std::optional<double> FlickerSums::p99() const {
    std::vector<double> means;
    for (size_t p = 0; p < pixel_steps.size(); ++p)
        if (pixel_steps[p]) means.push_back(pixel_squares[p] / pixel_steps[p]);
    if (means.empty()) return std::nullopt;
    const auto at = means.begin() + static_cast<std::ptrdiff_t>((means.size() - 1) * 99 / 100);
    std::nth_element(means.begin(), at, means.end());
    return std::sqrt(*at);
}

}  // namespace penumbra
