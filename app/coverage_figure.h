// SPDX-License-Identifier: MIT
// One pixel's sun as the node `cover` sees it: the samples, hidden and visible, and the outlines of what
// stands before them.
#pragma once

#include <array>
#include <string>

#include "host/truth/coverage.h"

namespace penumbra {

struct CoverageCaption {
    std::string shot;
    uint32_t frame = 0;
    std::array<uint32_t, 2> size{}, pixel{};
};

// How far around the sun's middle the figure shows triangles, in radii of the sun.
inline constexpr double coverage_figure_reach = 1.35;

// "17 triangles hide 53 of 128 samples: visibility .586"
std::string coverage_summary(const PixelCoverage& coverage);

// A whole SVG file. `coverage` lists triangles as far as coverage_figure_reach. Up is up in the world.
std::string coverage_figure(const SampledSun& sun, const CoverageReceiver& receiver,
                            const PixelCoverage& coverage, const CoverageCaption& caption);

}  // namespace penumbra
