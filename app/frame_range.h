// SPDX-License-Identifier: MIT
// Frames as the command line names them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "penumbra/diagnostic.h"

namespace penumbra {

using FrameRange = std::array<uint32_t, 2>;  // inclusive

// "A..B" or "A"; anything else is an error.
std::optional<FrameRange> parse_frames(const std::string& text, Diagnostics& diagnostics);
// The same of a shot; empty: all of its frames. Beyond its last one nothing would move: an error. Errors go
// to stderr.
std::optional<FrameRange> parse_frames(const std::string& text, uint32_t shot_frames);

}  // namespace penumbra
