// SPDX-License-Identifier: MIT
#include "app/frame_range.h"

#include <fmt/format.h>

#include <charconv>
#include <iostream>
#include <string_view>

namespace penumbra {
namespace {

std::optional<uint32_t> parse_index(std::string_view text) {
    uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    constexpr uint32_t most = 9'999'999;  // a loop over frames ends, and their numbers fit file names
    if (text.empty() || error != std::errc() || end != text.data() + text.size() || value > most)
        return std::nullopt;
    return value;
}

}  // namespace

std::optional<FrameRange> parse_frames(const std::string& text, Diagnostics& diagnostics) {
    const size_t dots = text.find("..");
    const auto first = parse_index(std::string_view(text).substr(0, dots));
    const auto last =
        dots == std::string::npos ? first : parse_index(std::string_view(text).substr(dots + 2));
    if (first && last && *first <= *last) return FrameRange{*first, *last};
    diagnostics.add({}, "--frames", fmt::format("\"{}\" is not A..B with A <= B <= 9999999", text));
    return std::nullopt;
}

std::optional<FrameRange> parse_frames(const std::string& text, uint32_t shot_frames) {
    if (text.empty()) return FrameRange{0, shot_frames - 1};
    Diagnostics diagnostics;
    const auto range = parse_frames(text, diagnostics);
    std::cerr << diagnostics.text();
    if (!range || (*range)[1] < shot_frames) return range;
    std::cerr << "--frames: " << text << " goes beyond the shot, whose frames are 0.." << shot_frames - 1
              << "\n";
    return std::nullopt;
}

}  // namespace penumbra
