// SPDX-License-Identifier: MIT
// Frames as the command line names them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace penumbra {

using FrameRange = std::array<uint32_t, 2>;  // inclusive

// "A..B" or "A"; empty: all of the shot's. Nothing, and a word on stderr, where it is neither.
std::optional<FrameRange> parse_frames(const std::string& text, uint32_t shot_frames);

}  // namespace penumbra
