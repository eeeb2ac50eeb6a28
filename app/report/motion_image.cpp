// SPDX-License-Identifier: MIT
#include "app/report/motion_image.h"

#include <algorithm>
#include <cmath>

#include "host/images/animation_file.h"
#include "host/images/image_file.h"

namespace penumbra::report {

std::vector<size_t> shown_in_motion(const std::vector<Contender>& contenders) {
    std::vector<size_t> shown;
    for (size_t c = 0; c < contenders.size(); ++c)
        if (!contenders[c].variant()) shown.push_back(c);
    return shown;
}

MotionGrid::MotionGrid(size_t panels) {
    const auto count = static_cast<uint32_t>(std::max<size_t>(panels, 1));
    columns = std::min(static_cast<uint32_t>(std::ceil(std::sqrt(count))), 4u);
    if (count == 3) columns = 3;  // beside each other rather than two and one
    rows = (count + columns - 1) / columns;
}

std::array<uint32_t, 2> MotionGrid::size(std::array<uint32_t, 2> panel) const {
    return {columns * (panel[0] + gap_px) - gap_px, rows * (panel[1] + gap_px) - gap_px};
}

std::array<uint32_t, 2> MotionGrid::corner(size_t index, std::array<uint32_t, 2> panel) const {
    const auto i = static_cast<uint32_t>(index);
    return {i % columns * (panel[0] + gap_px), i / columns * (panel[1] + gap_px)};
}

void write_motion_image(const std::filesystem::path& file, std::array<uint32_t, 2> size,
                        const std::vector<std::vector<std::span<const float>>>& masks) {
    constexpr uint8_t gap_grey = 128;
    const MotionGrid grid(masks.size());
    const auto [width, height] = grid.size(size);
    std::vector<std::vector<uint8_t>> frames(masks.at(0).size(),
                                             std::vector<uint8_t>(size_t{4} * width * height, gap_grey));
    for (size_t f = 0; f < frames.size(); ++f) {
        for (size_t texel = 3; texel < frames[f].size(); texel += 4) frames[f][texel] = 255;
        for (size_t panel = 0; panel < masks.size(); ++panel) {
            const auto [left, top] = grid.corner(panel, size);
            const std::span<const float> mask = masks[panel].at(f);
            for (uint32_t y = 0; y < size[1]; ++y)
                for (uint32_t x = 0; x < size[0]; ++x) {
                    const float v = mask[size_t{y} * size[0] + x];
                    uint8_t* texel = &frames[f][4 * (size_t{top + y} * width + left + x)];
                    if (std::isnan(v)) {  // magenta, as in the pictures that stand still
                        texel[0] = texel[2] = 255;
                        texel[1] = 0;
                    } else {
                        std::fill_n(texel, 3,
                                    static_cast<uint8_t>(std::lround(255 * std::clamp(v, 0.0f, 1.0f))));
                    }
                }
        }
    }
    write_file(file, webp_animation(width, height, frames, motion_frame_ms));
}

}  // namespace penumbra::report
