// SPDX-License-Identifier: MIT
// Which pixels a pipeline decides without a ray, and whether it is right: wrong verdicts, and how well the
// rays meet the penumbra (both ways: recall without precision can be had by tracing everything).
#pragma once

#include <optional>

#include "host/metrics/compared_frame.h"

namespace penumbra {

// One word per 8x4 pixels, rows of tiles from the top; bit i is pixel (i % 8, i / 8).
struct TileWords {
    std::span<const uint32_t> undecided;  // the pixel gets a ray
    std::span<const uint32_t> shadowed;   // decided shadowed; what is neither is decided lit
};
constexpr uint32_t tile_width = 8, tile_height = 4;

struct DecisionSums {
    uint64_t pixels = 0, penumbra = 0, traced = 0, penumbra_traced = 0;
    // Verdicts further from the truth than eps, .05, .25; those that say lit, or shadow, where it is neither
    // within eps.
    uint64_t beyond_eps = 0, beyond_05 = 0, beyond_25 = 0, false_lit = 0, false_shadow = 0;
    double squares = 0;  // of the verdicts' errors

    void add(const DecisionSums& other);
};

// Throws std::invalid_argument where the words are not those of the frame's tiles.
DecisionSums judge_decisions(const ComparedFrame& frame, const TileWords& words);

// Rays, one per undecided pixel, and those that answer otherwise than the same ray without an interval.
struct IntervalSums {
    uint64_t rays = 0, others = 0;

    void add(const IntervalSums& other);
    std::optional<double> share() const;
};

// Words as above; a bit of `hits` and `whole_hits` is 1 where the ray met something.
IntervalSums judge_interval(const ComparedFrame& frame, std::span<const uint32_t> undecided,
                            std::span<const uint32_t> hits, std::span<const uint32_t> whole_hits);

// Shares of all measured pixels, but recall = penumbra traced / penumbra, eta_ray = penumbra traced / traced
// and traced_per_penumbra = traced / penumbra: rays per pixel that needs them, where a pixel has one.
struct DecisionMetrics {
    std::optional<double> beyond_eps, beyond_05, beyond_25, false_lit, false_shadow, rms, recall, eta_ray,
        traced_per_penumbra;
};
DecisionMetrics metrics_of(const DecisionSums& sums);

}  // namespace penumbra
