// SPDX-License-Identifier: MIT
// Texels as the graph stores them to planes of numbers, for files and statistics.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "host/images/image_file.h"
#include "penumbra/format.h"

namespace penumbra {

// One plane per channel, as far as there are `names` for them: the last channels may have none.
// `texels` holds width * height tightly packed texels.
PlanarImage decode_texels(Format format, uint32_t width, uint32_t height, std::span<const std::byte> texels,
                          const std::vector<std::string>& names);

}  // namespace penumbra
