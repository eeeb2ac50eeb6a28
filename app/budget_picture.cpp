// SPDX-License-Identifier: MIT
#include "app/budget_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "app/captured_values.h"
#include "host/metrics/decisions.h"

namespace penumbra {
namespace {

constexpr uint32_t most_rays = 32;
using Color = std::array<uint8_t, 3>;

constexpr Color nowhere{20, 20, 24}, none{92, 92, 96};
// By octaves of rays: 1, 2, 4, 8, 16, 32.
constexpr std::array<Color, 6> ramp{
    {{38, 84, 156}, {32, 132, 148}, {66, 168, 92}, {190, 188, 56}, {240, 142, 40}, {255, 244, 224}}};

Color color_of(uint32_t rays) {
    if (rays == 0) return none;
    const double at = std::log2(double(rays));
    const auto below = std::min(static_cast<size_t>(at), ramp.size() - 2);
    Color color{};
    for (size_t i = 0; i < color.size(); ++i)
        color[i] = static_cast<uint8_t>(
            std::lround(std::lerp(ramp[below][i], ramp[below + 1][i], at - double(below))));
    return color;
}

}  // namespace

uint64_t BudgetPicture::receivers() const {
    return std::accumulate(pixels.begin(), pixels.end(), uint64_t{0});
}

std::string BudgetPicture::summary() const {
    const auto share = [&](uint32_t from, uint32_t to) {
        const uint64_t some = std::accumulate(pixels.begin() + from, pixels.begin() + to + 1, uint64_t{0});
        return 100.0 * double(some) / double(std::max<uint64_t>(receivers(), 1));
    };
    return fmt::format(
        "{} rays for {} pixels that look at the sun: none for {:.1f} %, one for {:.1f} %, 2 to 8 for {:.1f} "
        "%, 9 to 32 for {:.1f} %",
        rays, receivers(), share(0, 0), share(1, 1), share(2, 8), share(9, most_rays));
}

const std::vector<std::string>& budget_captures() {
    static const std::vector<std::string> names{"sunward_words", "ray_words", "ray_bits", "proved"};
    return names;
}

BudgetPicture budget_picture(const Session& session) {
    BudgetPicture out;
    out.size = {session.plan().extent.width, session.plan().extent.height};
    const auto sunward = captured_values<uint32_t>(session, "sunward_words"),
               first = captured_values<uint32_t>(session, "ray_words"),
               further = captured_values<uint32_t>(session, "ray_bits"),
               proved = captured_values<uint32_t>(session, "proved");
    const uint32_t columns = (out.size[0] + tile_width - 1) / tile_width, proved_words = (columns + 31) / 32;
    for (uint32_t y = 0; y < out.size[1]; ++y)
        for (uint32_t x = 0; x < out.size[0]; ++x) {
            const size_t tile = size_t{y / tile_height} * columns + x / tile_width;
            const uint32_t bit = 1u << (y % tile_height * tile_width + x % tile_width);
            // Of a proved tile ray_words says what its pixels know, which cast none.
            const bool cast = (first[tile] & bit) != 0 &&
                              !(proved[size_t{y / tile_height} * proved_words + x / tile_width / 32] >>
                                    (x / tile_width % 32) &
                                1u);
            Color color = nowhere;
            if (sunward[tile] & bit) {
                // The highest bit says how many further ones there are.
                const uint32_t more = further[size_t{y} * out.size[0] + x];
                const uint32_t rays = cast ? std::max<uint32_t>(1, uint32_t(std::bit_width(more))) : 0;
                ++out.pixels[std::min(rays, most_rays)];
                out.rays += rays;
                color = color_of(std::min(rays, most_rays));
            }
            out.rgba.insert(out.rgba.end(), {color[0], color[1], color[2], 255});
        }
    return out;
}

}  // namespace penumbra
