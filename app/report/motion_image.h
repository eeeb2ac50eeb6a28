// SPDX-License-Identifier: MIT
// The masks of a moving shot side by side, as one picture that moves: so they stay in step.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "app/report/results.h"

namespace penumbra::report {

// Who is in the picture: pipelines as they ship, not what plain rays they are compared with, but `raw`.
std::vector<size_t> shown_in_motion(const std::vector<Contender>& contenders);

// How panels lie: row by row from the upper left, with a gap between.
struct MotionGrid {
    uint32_t columns = 1, rows = 1, gap_px = 2;
    explicit MotionGrid(size_t panels);
    // Of the whole picture, and where a panel begins.
    std::array<uint32_t, 2> size(std::array<uint32_t, 2> panel) const;
    std::array<uint32_t, 2> corner(size_t index, std::array<uint32_t, 2> panel) const;
};

constexpr int motion_frame_ms = 100;  // slow enough to be looked at

// `masks`: by panel, by frame, rows from the top. An animated WebP; throws FileError.
void write_motion_image(const std::filesystem::path& file, std::array<uint32_t, 2> size,
                        const std::vector<std::vector<std::span<const float>>>& masks);

}  // namespace penumbra::report
