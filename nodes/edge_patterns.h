// SPDX-License-Identifier: MIT
// What nine shadow rays say together: the expected visibility of a pixel given the bits of 3x3 pixels, made at
// build time.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace penumbra {

// Of the centre's visibility, over all shadow edges that could have left these bits.
struct PatternEstimate {
    double mean = 0.0;
    double variance = 0.0;
};

// By pattern: bit 3 * (y + 1) + x + 1 is set where the pixel at (x, y) from the centre is lit.
inline constexpr uint32_t edge_pattern_count = 512;
using EdgePatterns = std::array<PatternEstimate, edge_pattern_count>;

EdgePatterns edge_patterns();

// The table of the node `accumulate`: mean and four times the variance in 8 bits each, pattern by pattern.
std::vector<uint8_t> edge_pattern_table();

}  // namespace penumbra
