// SPDX-License-Identifier: MIT
// Resources, masks and their errors as pictures of 8 bits: what the window and screenshots show.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/images/image_file.h"

namespace penumbra::viewer {

struct Picture {
    uint32_t width = 0, height = 0;
    std::vector<uint8_t> rgba;  // rows from the top
    std::string note;           // what grey stands for, where it is not the value itself

    uint8_t* at(uint32_t x, uint32_t y) { return rgba.data() + 4 * (size_t{y} * width + x); }
};

// Colour ("R", "G", "B" ..) sRGB-encoded, radiance exposed; vectors ("X", "Y" ..) from -1 .. 1; words by the
// share of their bits that are set; one channel as grey: 0 .. 1 as it is, and where any value lies outside,
// from the least to the greatest, as `note` says. NaN is magenta.
Picture picture_of(const PlanarImage& image);

// A mask 0 .. 1. `known`: 0 where nothing is known yet, which is shown as a dark pattern; empty: all is.
Picture mask_picture(uint32_t width, uint32_t height, std::span<const float> mask,
                     std::span<const float> known = {});

// mask - truth where `known` is not 0: too light is red, too dark is blue, in the square root of the
// difference, so that a hundredth is seen; the mask itself is faint behind.
Picture error_picture(uint32_t width, uint32_t height, std::span<const float> mask,
                      std::span<const float> truth, std::span<const float> known);

// `left` up to the column at `share` of the width, `right` from there on, and a line between. Of one size.
Picture split(Picture left, const Picture& right, double share);

}  // namespace penumbra::viewer
