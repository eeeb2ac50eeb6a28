// SPDX-License-Identifier: MIT
// What the beams of a few tiles see, drawn along the beam.
#pragma once

#include <span>
#include <string>

#include "app/coverage_figure.h"
#include "app/tile_beams.h"

namespace penumbra {

// "tile 41,23 (32 pixels): dark, closed off by 3 triangles"
std::string beam_summary(const TileBeam& beam);

// A whole SVG file with a picture for each beam. Up is up in the world. Of the caption all but the pixel is
// used.
std::string beam_figure(std::span<const TileBeam> beams, const CoverageCaption& caption);

}  // namespace penumbra
