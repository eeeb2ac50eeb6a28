// SPDX-License-Identifier: MIT
// Behind a moving edge: at every pixel of the penumbra whose truth changes, the truth's gradient is the
// edge's normal, and the sign of the change says where the edge is heading. The field of headings is carried
// outwards to the pixels near by, since the image's edge may lie beside the true one; then one shift along it
// is sought for all of them.
#include "host/metrics/lag.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host/metrics/bilinear.h"

namespace penumbra {
namespace {

constexpr int farthest_px = 48;        // a lag is looked for
constexpr double least_change = 1e-3;  // of the truth per frame: a shadow that moves
constexpr double least_slope = 2e-3;   // per pixel: an edge with a direction
constexpr size_t fewest_pixels = 16;

struct Heading {
    float x = 0, y = 0;  // where the edge is heading; 0, 0: unknown
    bool known() const { return x != 0 || y != 0; }
};

// Light is where the truth rises; a shadow that grows heads there, one that shrinks away from it.
std::vector<Heading> headings(const ComparedFrame& now, std::span<const float> before) {
    std::vector<Heading> out(now.pixels());
    for (uint32_t y = 1; y + 1 < now.height; ++y)
        for (uint32_t x = 1; x + 1 < now.width; ++x) {
            const size_t p = size_t{y} * now.width + x;
            if (!now.counted[p] || !in_penumbra(static_cast<double>(now.truth[p]))) continue;
            if (!now.counted[p - 1] || !now.counted[p + 1] || !now.counted[p - now.width] ||
                !now.counted[p + now.width])
                continue;
            const auto change = static_cast<double>(now.truth[p] - before[p]);
            const double dx = 0.5 * static_cast<double>(now.truth[p + 1] - now.truth[p - 1]),
                         dy = 0.5 * static_cast<double>(now.truth[p + now.width] - now.truth[p - now.width]),
                         slope = std::hypot(dx, dy);
            if (std::abs(change) < least_change || slope < least_slope) continue;
            const double towards = (change < 0 ? 1 : -1) / slope;
            out[p] = {static_cast<float>(dx * towards), static_cast<float>(dy * towards)};
        }
    return out;
}

// Breadth first, so that every pixel gets the heading of about the nearest that has one.
void spread(std::vector<Heading>& field, const ComparedFrame& frame) {
    std::vector<size_t> front, next;
    for (size_t p = 0; p < field.size(); ++p)
        if (field[p].known()) front.push_back(p);
    for (int ring = 0; ring < farthest_px && !front.empty(); ++ring) {
        next.clear();
        for (const size_t p : front) {
            const auto visit = [&](bool inside, size_t q) {
                if (!inside || field[q].known() || !frame.counted[q]) return;
                field[q] = field[p];
                next.push_back(q);
            };
            visit(p % frame.width > 0, p - 1);
            visit(p % frame.width + 1 < frame.width, p + 1);
            visit(p >= frame.width, p - frame.width);
            visit(p + frame.width < field.size(), p + frame.width);
        }
        front.swap(next);
    }
}

// Of v(x) - v*(x + s heading), over the pixels that every shift looked at keeps inside.
double misfit(const ComparedFrame& frame, std::span<const Heading> field, std::span<const size_t> pixels,
              double shift) {
    double sum = 0;
    for (const size_t p : pixels) {
        const double x = static_cast<double>(p % frame.width) + 0.5 + shift * static_cast<double>(field[p].x),
                     y = static_cast<double>(p / frame.width) + 0.5 + shift * static_cast<double>(field[p].y);
        const auto taps = bilinear_taps(std::clamp(x, 0.5, frame.width - 0.5),
                                        std::clamp(y, 0.5, frame.height - 0.5), frame.width, frame.height);
        const double truth = taps ? taps->of(frame.truth) : static_cast<double>(frame.truth[p]);
        for (const std::span<const float> seed : frame.seeds) {
            const auto v = static_cast<double>(seed[p]);
            if (std::isfinite(v)) sum += (v - truth) * (v - truth);
        }
    }
    return sum;
}

}  // namespace

std::optional<double> lag_px(const ComparedFrame& now, std::span<const float> truth_before) {
    check_sizes(now, "lag_px");
    if (truth_before.size() != now.pixels()) throw std::invalid_argument("lag_px: images of different sizes");
    std::vector<Heading> field = headings(now, truth_before);
    const auto sources = static_cast<size_t>(
        std::count_if(field.begin(), field.end(), [](const Heading& h) { return h.known(); }));
    if (sources < fewest_pixels) return std::nullopt;
    spread(field, now);
    std::vector<size_t> pixels;
    for (size_t p = 0; p < field.size(); ++p)
        if (field[p].known()) pixels.push_back(p);

    int best = 0;
    double least = misfit(now, field, pixels, 0);
    for (int shift = -farthest_px; shift <= farthest_px; ++shift) {
        const double value = misfit(now, field, pixels, shift);
        if (value < least) {
            least = value;
            best = shift;
        }
    }
    double low = best - 1, high = best + 1;
    constexpr double golden = 0.6180339887498949;
    double a = high - golden * (high - low), b = low + golden * (high - low);
    double at_a = misfit(now, field, pixels, a), at_b = misfit(now, field, pixels, b);
    while (high - low > 0.005) {
        if (at_a < at_b) {
            high = b;
            b = a;
            at_b = at_a;
            a = high - golden * (high - low);
            at_a = misfit(now, field, pixels, a);
        } else {
            low = a;
            a = b;
            at_a = at_b;
            b = low + golden * (high - low);
            at_b = misfit(now, field, pixels, b);
        }
    }
    return 0.5 * (low + high);
}

namespace {

constexpr float sudden = 0.5f, still = 0.05f;
constexpr double settled = 0.1;

}  // namespace

void StepFinder::add(uint32_t frame, std::span<const float> truth, std::span<const uint8_t> counted) {
    // What moves on after the step has no single truth to be late for.
    size_t kept = 0;
    for (size_t i = 0; i < best_.pixels.size(); ++i) {
        const uint32_t p = best_.pixels[i];
        if (p >= truth.size() || std::abs(truth[p] - new_truth_[i]) > still) continue;
        best_.pixels[kept] = p;
        changes_[kept] = changes_[i];
        new_truth_[kept++] = new_truth_[i];
    }
    best_.pixels.resize(kept);
    changes_.resize(kept);
    new_truth_.resize(kept);

    if (last_.size() == truth.size() && frame == last_frame_ + 1) {
        Step found{frame, {}, 0};
        for (uint32_t p = 0; p < truth.size(); ++p)
            if (counted[p] && std::abs(truth[p] - last_[p]) > sudden) found.pixels.push_back(p);
        if (found.pixels.size() > best_.pixels.size()) {
            new_truth_.clear();
            changes_.clear();
            for (const uint32_t p : found.pixels) {
                new_truth_.push_back(truth[p]);
                changes_.push_back(std::abs(truth[p] - last_[p]));
            }
            best_ = std::move(found);
        }
    }
    last_frame_ = frame;
    last_.assign(truth.begin(), truth.end());
}

std::optional<StepFinder::Step> StepFinder::step() const {
    if (best_.pixels.size() < fewest_pixels) return std::nullopt;
    Step step = best_;
    for (const float change : changes_) step.size += static_cast<double>(change);
    return step;
}

double step_remainder(const StepFinder::Step& step, const ComparedFrame& frame) {
    check_sizes(frame, "step_remainder");
    double sum = 0;
    for (const uint32_t p : step.pixels)
        for (const std::span<const float> seed : frame.seeds) {
            const double error = std::abs(static_cast<double>(seed[p]) - static_cast<double>(frame.truth[p]));
            sum += (std::isfinite(error) ? error : 1) / static_cast<double>(frame.seeds.size());
        }
    return sum / step.size;
}

StepResponse step_response(std::span<const double> remainders) {
    StepResponse out;
    if (remainders.empty()) return out;
    double sum = 0;
    size_t after = 0;  // the first frame from which on all are settled
    for (size_t k = 0; k < remainders.size(); ++k) {
        sum += remainders[k];
        if (!(remainders[k] <= settled)) after = k + 1;
    }
    out.residual = sum;
    if (after < remainders.size()) out.k90 = static_cast<double>(after);
    return out;
}

}  // namespace penumbra
