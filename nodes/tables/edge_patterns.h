// SPDX-License-Identifier: MIT
// What nine shadow rays say together: the expected visibility of a pixel given the bits of 3x3 pixels, made
// at build time.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace penumbra {

// By pattern: bit 3 * (y + 1) + x + 1 is set where the pixel at (x, y) from the centre is lit. The centre's
// expected visibility over all shadow edges that could have left these bits.
inline constexpr uint32_t edge_pattern_count = 512;
using EdgePatterns = std::array<double, edge_pattern_count>;

EdgePatterns edge_patterns();

// The table of the node `soften`: pattern by pattern in 8 bits.
std::vector<uint8_t> edge_pattern_table();

}  // namespace penumbra
