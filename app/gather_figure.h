// SPDX-License-Identifier: MIT
// A pixel's neighbourhood as it was rendered, one ray a pixel, and what these rays say of its own sun.
#pragma once

#include <string>

#include "app/coverage_figure.h"
#include "app/gathered_rays.h"

namespace penumbra {

// "38 of 121 rays are tests of this pixel's sun, 17 of them lit: visibility .447; blockers 2.31 m away"
std::string gather_summary(const Gathered& gathered);

// A whole SVG file of two figures. Up is the image's on the left, and an axis across the light on the right.
std::string gather_figure(const Gathered& gathered, const CoverageCaption& caption);

}  // namespace penumbra
