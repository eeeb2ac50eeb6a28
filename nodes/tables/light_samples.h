// SPDX-License-Identifier: MIT
// Samples of a light and the table of half-planes of the node `cover`, made at build time: for the unit disc,
// and for the square [-1, 1]^2 that rectangles and tubes are.
//
// A triangle's edge, seen from a receiver, cuts the light in two: a half-plane n.x + c >= 0, |n| = 1.
// The table says which of N samples lie in it, by the direction of n and by *how many* they are: entry k of a
// direction holds the k samples that lie farthest along n. Asked for N times the half-plane's exact area,
// rounded up or down by a fraction that differs from pixel to pixel, it covers the right area on average,
// whatever the direction, and is never off by as much as one sample; so a straight edge costs nothing for
// having finitely many samples, which corners and slivers alone see.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shaders/common/blocks.h"

namespace penumbra {

using LightSample = std::array<double, 2>;

inline constexpr std::array<uint32_t, 3> light_sample_counts = {64, 128, 256};

enum class LightShape { disc, square };

// Directions of n are kept over half a circle, since the other half are complements. Bins are of equal width
// in p = n.x / (|n.x| + |n.y|), -1 to 1, which takes no arc tangent.
using blocks::HALF_PLANE_DIRECTIONS;

// The unit normal in the middle of a bin; y > 0.
std::array<double, 2> half_plane_normal(uint32_t bin);

// `count` points of the shape, as even in every direction as annealing gets them: in each of many
// directions the k-th point lies near the line behind which k - 1/2 of `count` parts of the shape's area lie.
// On a grid of 1 / 32767. Seeded.
std::vector<LightSample> light_samples(uint32_t count, LightShape shape = LightShape::disc);

// Area of the unit disc's part x >= -c, as a share of the disc; c in [-1, 1].
double half_disc_area(double c);
// Area of the square's part n.x >= -c, as a share of the square; |n| = 1, any c.
double half_square_area(const std::array<double, 2>& n, double c);

// Entry (k, bin) at (bin * (count + 1) + k) * count / 32, of count / 32 words: the k samples farthest along
// the bin's normal. Bit i of word w is sample 32 w + i. `count` is a multiple of 32.
std::vector<uint32_t> half_plane_table(const std::vector<LightSample>& samples);

}  // namespace penumbra
