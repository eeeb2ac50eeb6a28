// SPDX-License-Identifier: MIT
#include "app/view/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include "host/images/srgb.h"

namespace penumbra::viewer {
namespace {

uint8_t byte_of(float value) {
    return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255));
}

// Values that are sRGB-encoded. Tables, since a power per channel and frame would cost more than the copy
// from the device.
class Encoding {
  public:
    explicit Encoding(bool light) : greatest_(light ? 8 : 1) {
        for (int i = 0; i <= steps * greatest_; ++i) {
            const float value = static_cast<float>(i) / steps, v = light ? exposed(value) : value;
            table_.push_back(byte_of(srgb_of_linear(v)));
        }
    }
    uint8_t operator()(float value) const {
        return table_[static_cast<size_t>(std::clamp(value, 0.0f, float(greatest_)) * steps + 0.5f)];
    }

  private:
    static constexpr int steps = 4096;
    int greatest_;  // 8 is white to a half of a step of 255
    std::vector<uint8_t> table_;
};

void put(Picture& picture, size_t i, uint8_t r, uint8_t g, uint8_t b) {
    uint8_t* p = picture.rgba.data() + 4 * i;
    p[0] = r;
    p[1] = g;
    p[2] = b;
    p[3] = 255;
}

Picture blank(uint32_t width, uint32_t height) {
    return {width, height, std::vector<uint8_t>(size_t{width} * height * 4), ""};
}

// Of pixels of which nothing is known: no grey that a mask may have.
void put_unknown(Picture& picture, size_t i) {
    const size_t x = i % picture.width, y = i / picture.width;
    const bool dark = ((x + y) / 4) % 2 != 0;
    put(picture, i, dark ? 24 : 40, dark ? 28 : 46, dark ? 48 : 70);
}

void put_grey(Picture& picture, const std::vector<float>& values, std::array<float, 2> range) {
    for (size_t i = 0; i < values.size(); ++i) {
        if (std::isnan(values[i])) {
            put(picture, i, 255, 0, 255);
            continue;
        }
        const uint8_t grey = byte_of((values[i] - range[0]) / (range[1] - range[0]));
        put(picture, i, grey, grey, grey);
    }
}

// 0 .. 1, or where the values leave that, the range that they have.
std::array<float, 2> range_of(const std::vector<float>& values) {
    std::array<float, 2> range{0, 1};
    bool first = true;
    for (const float v : values) {
        if (!std::isfinite(v)) continue;
        if (first) range = {v, v};
        first = false;
        range = {std::min(range[0], v), std::max(range[1], v)};
    }
    if (first || (range[0] >= 0 && range[1] <= 1) || range[0] == range[1]) return {0, 1};
    return range;
}

}  // namespace

Picture picture_of(const PlanarImage& image) {
    Picture picture = blank(image.width, image.height);
    const Plane& first = image.planes.front();
    if (first.type == PlaneType::uint) {
        for (size_t i = 0; i < first.words.size(); ++i) {
            const uint8_t grey = byte_of(static_cast<float>(std::popcount(first.words[i])) / 32);
            put(picture, i, grey, grey, grey);
        }
        picture.note = "bits set, of 32";
        return picture;
    }
    if (image.planes.size() == 1) {
        const std::array<float, 2> range = range_of(first.values);
        if (range != std::array<float, 2>{0, 1})
            picture.note = fmt::format("{:.4g} (black) to {:.4g} (white)", range[0], range[1]);
        put_grey(picture, first.values, range);
        return picture;
    }
    const bool color = first.name == "R";
    static const Encoding of_color(false), of_light(true);
    const Encoding& encode = image.light ? of_light : of_color;
    if (!color) picture.note = "-1 .. 1 as 0 .. 1";
    for (size_t i = 0; i < first.values.size(); ++i) {
        std::array<float, 3> v{};
        for (size_t c = 0; c < 3 && c < image.planes.size(); ++c) v[c] = image.planes[c].values[i];
        if (std::isnan(v[0]) || std::isnan(v[1]) || std::isnan(v[2]))
            put(picture, i, 255, 0, 255);
        else if (color)
            put(picture, i, encode(v[0]), encode(v[1]), encode(v[2]));
        else
            put(picture, i, byte_of(0.5f + 0.5f * v[0]), byte_of(0.5f + 0.5f * v[1]),
                image.planes.size() > 2 ? byte_of(0.5f + 0.5f * v[2]) : 0);
    }
    return picture;
}

Picture mask_picture(uint32_t width, uint32_t height, std::span<const float> mask,
                     std::span<const float> known) {
    Picture picture = blank(width, height);
    for (size_t i = 0; i < mask.size(); ++i) {
        const uint8_t grey = byte_of(mask[i]);
        if (!known.empty() && known[i] == 0)
            put_unknown(picture, i);
        else if (std::isnan(mask[i]))
            put(picture, i, 255, 0, 255);
        else
            put(picture, i, grey, grey, grey);
    }
    return picture;
}

Picture error_picture(uint32_t width, uint32_t height, std::span<const float> mask,
                      std::span<const float> truth, std::span<const float> known) {
    Picture picture = blank(width, height);
    for (size_t i = 0; i < mask.size(); ++i) {
        const float error = mask[i] - truth[i];
        if (known[i] == 0) {
            put_unknown(picture, i);
        } else if (std::isnan(error)) {
            put(picture, i, 255, 0, 255);
        } else {
            const float strength = std::sqrt(std::min(std::abs(error), 1.0f)), faint = 0.15f * mask[i];
            put(picture, i, byte_of(faint + (error > 0 ? strength : 0)), byte_of(faint),
                byte_of(faint + (error < 0 ? strength : 0)));
        }
    }
    return picture;
}

Picture split(Picture left, const Picture& right, double share) {
    if (left.width != right.width || left.height != right.height)
        throw std::invalid_argument("split: pictures of two sizes");
    const auto column = static_cast<uint32_t>(std::lround(std::clamp(share, 0.0, 1.0) * left.width));
    for (uint32_t y = 0; y < left.height; ++y) {
        if (column >= left.width) continue;
        const size_t from = 4 * (size_t{y} * left.width + column);
        std::copy_n(right.rgba.begin() + static_cast<ptrdiff_t>(from), 4 * (left.width - column),
                    left.rgba.begin() + static_cast<ptrdiff_t>(from));
        if (column > 0) put(left, size_t{y} * left.width + column, 255, 200, 0);
    }
    return left;
}

}  // namespace penumbra::viewer
