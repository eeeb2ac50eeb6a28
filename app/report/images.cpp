// SPDX-License-Identifier: MIT
#include "app/report/images.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "app/report/html.h"
#include "graph/read_text.h"
#include "host/images/image_file.h"

namespace penumbra::report {
std::string file_bytes(const std::filesystem::path& file) {
    auto bytes = read_text(file);
    if (!bytes || bytes->empty()) throw FileError(file.string() + ": cannot be read");
    return std::move(*bytes);
}

void write_mask_image(const std::filesystem::path& file, std::array<uint32_t, 2> size,
                      std::span<const float> mask) {
    write_png_linear(file, size[0], size[1], mask);
}

std::array<float, 3> error_color(double error) {
    // Linear light; both ends are about as dark, so that neither sign looks the worse one.
    constexpr std::array<float, 3> bright{0.72f, 0.20f, 0.01f}, dark{0.02f, 0.17f, 0.60f};
    if (!std::isfinite(error)) return {1, 0, 1};
    const auto t = static_cast<float>(std::min(std::abs(error) / error_at_full, 1.0));
    const std::array<float, 3>& end = error > 0 ? bright : dark;
    return {1 + t * (end[0] - 1), 1 + t * (end[1] - 1), 1 + t * (end[2] - 1)};
}

void write_error_image(const std::filesystem::path& file, std::array<uint32_t, 2> size,
                       std::span<const float> mask, std::span<const float> truth,
                       std::span<const uint8_t> counted) {
    constexpr std::array<float, 3> grey{0.6f, 0.6f, 0.6f};
    std::vector<float> rgb;
    for (size_t p = 0; p < mask.size(); ++p) {
        const auto color =
            counted[p] ? error_color(static_cast<double>(mask[p]) - static_cast<double>(truth[p])) : grey;
        rgb.insert(rgb.end(), color.begin(), color.end());
    }
    write_png_color(file, size[0], size[1], rgb);
}

std::string data_uri(const std::filesystem::path& file) {
    return fmt::format("data:image/{};base64,{}", file.extension().string().substr(1),
                       base64(file_bytes(file)));
}

}  // namespace penumbra::report
