// SPDX-License-Identifier: MIT
#include "app/report/crops.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace penumbra::report {
namespace {

// For one part of an address: all but letters, digits and -._~ as %XX (RFC 3986).
std::string percent(const std::string& text) {
    std::string out;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        const bool plain =
            (byte < 128 && std::isalnum(byte)) || std::string_view("-._~").find(c) != std::string_view::npos;
        out += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
    }
    return out;
}

}  // namespace

std::array<double, 2> worst_crop(std::array<uint32_t, 2> size, std::span<const uint8_t> errors) {
    const uint32_t width = size[0], height = size[1];
    const uint32_t crop_w = std::max(width / crop_zoom, 1u), crop_h = std::max(height / crop_zoom, 1u);
    // Sums over all that is above and to the left.
    std::vector<uint64_t> sums((width + 1) * size_t{height + 1});
    const auto at = [&](uint32_t x, uint32_t y) -> uint64_t& { return sums[size_t{y} * (width + 1) + x]; };
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const uint64_t error = errors[size_t{y} * width + x];
            at(x + 1, y + 1) = at(x, y + 1) + at(x + 1, y) - at(x, y) + error * error;
        }
    std::array<double, 2> middle{0.5, 0.5};
    uint64_t worst = 0;
    for (uint32_t y = 0; y + crop_h <= height; ++y)
        for (uint32_t x = 0; x + crop_w <= width; ++x) {
            const uint64_t sum =
                at(x + crop_w, y + crop_h) - at(x, y + crop_h) - at(x + crop_w, y) + at(x, y);
            if (sum <= worst) continue;
            worst = sum;
            middle = {(x + crop_w / 2.0) / width, (y + crop_h / 2.0) / height};
        }
    return middle;
}

std::string crop_fragment(const std::string& shot, const std::string& left, const std::string& right,
                          std::array<double, 2> middle) {
    return fmt::format("crop/{}/{}/{}/{:.4f}/{:.4f}/{}", percent(shot), percent(left), percent(right),
                       middle[0], middle[1], crop_zoom);
}

}  // namespace penumbra::report
