// SPDX-License-Identifier: MIT
#include "host/metrics/decisions.h"

#include <cmath>
#include <stdexcept>

namespace penumbra {

void DecisionSums::add(const DecisionSums& other) {
    pixels += other.pixels;
    penumbra += other.penumbra;
    traced += other.traced;
    penumbra_traced += other.penumbra_traced;
    beyond_eps += other.beyond_eps;
    beyond_05 += other.beyond_05;
    beyond_25 += other.beyond_25;
    false_lit += other.false_lit;
    false_shadow += other.false_shadow;
    squares += other.squares;
}

namespace {

// Where a pixel's bit is among a frame's words.
class TileBits {
  public:
    explicit TileBits(const ComparedFrame& frame)
        : width_(frame.width),
          tiles_x_((frame.width + tile_width - 1) / tile_width),
          tiles_y_((frame.height + tile_height - 1) / tile_height) {}

    size_t words() const { return tiles_x_ * tiles_y_; }
    bool at(std::span<const uint32_t> words, size_t pixel) const {
        const size_t x = pixel % width_, y = pixel / width_;
        const size_t tile = y / tile_height * tiles_x_ + x / tile_width;
        return words[tile] >> (y % tile_height * tile_width + x % tile_width) & 1;
    }

  private:
    size_t width_, tiles_x_, tiles_y_;
};

}  // namespace

DecisionSums judge_decisions(const ComparedFrame& frame, const TileWords& words) {
    const TileBits bits(frame);
    if (words.undecided.size() != bits.words() || words.shadowed.size() != bits.words() ||
        frame.truth.size() != frame.pixels() || frame.counted.size() != frame.pixels())
        throw std::invalid_argument("judge_decisions: not one word per tile");
    DecisionSums sums;
    for (size_t p = 0; p < frame.pixels(); ++p) {
        if (!frame.counted[p]) continue;
        const double truth = static_cast<double>(frame.truth[p]);
        const bool traced = bits.at(words.undecided, p);
        ++sums.pixels;
        sums.penumbra += in_penumbra(truth);
        sums.traced += traced;
        sums.penumbra_traced += traced && in_penumbra(truth);
        if (traced) continue;
        const bool lit = !bits.at(words.shadowed, p);
        const double error = std::abs((lit ? 1 : 0) - truth);
        sums.beyond_eps += error > penumbra_eps;
        sums.beyond_05 += error > 0.05;
        sums.beyond_25 += error > 0.25;
        sums.false_lit += lit && error > penumbra_eps;
        sums.false_shadow += !lit && error > penumbra_eps;
        sums.squares += error * error;
    }
    return sums;
}

void IntervalSums::add(const IntervalSums& other) {
    rays += other.rays;
    others += other.others;
}

std::optional<double> IntervalSums::share() const {
    return rays ? std::optional(static_cast<double>(others) / static_cast<double>(rays)) : std::nullopt;
}

IntervalSums judge_interval(const ComparedFrame& frame, std::span<const uint32_t> undecided,
                            std::span<const uint32_t> hits, std::span<const uint32_t> whole_hits) {
    const TileBits bits(frame);
    for (const auto words : {undecided, hits, whole_hits})
        if (words.size() != bits.words())
            throw std::invalid_argument("judge_interval: not one word per tile");
    IntervalSums sums;
    for (size_t p = 0; p < frame.pixels(); ++p) {
        if (!frame.counted[p] || !bits.at(undecided, p)) continue;
        ++sums.rays;
        sums.others += bits.at(hits, p) != bits.at(whole_hits, p);
    }
    return sums;
}

DecisionMetrics metrics_of(const DecisionSums& sums) {
    const auto share = [](uint64_t a, uint64_t b) {
        return b ? std::optional(static_cast<double>(a) / static_cast<double>(b)) : std::nullopt;
    };
    DecisionMetrics out;
    out.beyond_eps = share(sums.beyond_eps, sums.pixels);
    out.beyond_05 = share(sums.beyond_05, sums.pixels);
    out.beyond_25 = share(sums.beyond_25, sums.pixels);
    out.false_lit = share(sums.false_lit, sums.pixels);
    out.false_shadow = share(sums.false_shadow, sums.pixels);
    if (sums.pixels) out.rms = std::sqrt(sums.squares / static_cast<double>(sums.pixels));
    out.recall = share(sums.penumbra_traced, sums.penumbra);
    out.eta_ray = share(sums.penumbra_traced, sums.traced);
    out.traced_per_penumbra = share(sums.traced, sums.penumbra);
    return out;
}

}  // namespace penumbra
