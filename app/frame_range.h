// SPDX-License-Identifier: MIT
// Frames as the command line names them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace penumbra {

using FrameRange = std::array<uint32_t, 2>;  // inclusive

// "A..B" or "A". Nothing, and a word on stderr, where it is neither.
std::optional<FrameRange> parse_frames(const std::string& text);
// The same of a shot; empty: all of its frames. Beyond its last one nothing would move: an error.
std::optional<FrameRange> parse_frames(const std::string& text, uint32_t shot_frames);

}  // namespace penumbra
