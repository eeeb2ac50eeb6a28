// SPDX-License-Identifier: MIT
// What stb_image 2.27 takes on trust, looked at before it sees a file.
#pragma once

#include <cstddef>
#include <span>

namespace penumbra {

// Whether this is a PNG each chunk of which ends within the file (stb_image makes room for what a chunk
// claims, up to 2 GiB, before it reads any of it), or a JPEG none of whose Huffman tables has more than the
// 256 codes that there is room for (stb_image writes the rest behind it).
bool is_sound_image(std::span<const std::byte> bytes);

}  // namespace penumbra
