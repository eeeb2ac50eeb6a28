// SPDX-License-Identifier: MIT
// Blue-noise tiles for the sampling of shadow rays, made at build time.
#pragma once

#include <cstdint>
#include <vector>

namespace penumbra {

inline constexpr uint32_t blue_noise_size = 128;  // texels along a side; the tile wraps around

// The order in which void-and-cluster fills a size x size torus: a permutation of 0..size^2-1, row by row.
// Every prefix of the order is spread as evenly as the pattern allows. Integer arithmetic decides, so the
// same seed gives the same tile everywhere.
std::vector<uint32_t> void_and_cluster(uint32_t size, uint32_t seed);

// The table of the node `trace`: two independent tiles as 16-bit fixed point in [0, 1), texel = first |
// second << 16.
std::vector<uint32_t> blue_noise_table();

}  // namespace penumbra
