// SPDX-License-Identifier: MIT
// A straight penumbra with its exact visibility, and images of it made in any way: what metrics are tested
// on.
#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include "host/metrics/compared_frame.h"
#include "host/truth/analytic.h"

namespace penumbra::test {

inline double one_ray(double v, std::mt19937& random) {
    return std::uniform_real_distribution<double>()(random) < v ? 1 : 0;
}

inline double mean_of_rays(double v, std::mt19937& random, int rays) {
    double sum = 0;
    for (int i = 0; i < rays; ++i) sum += one_ray(v, random);
    return sum / rays;
}

struct PenumbraImages {
    uint32_t width = 128, height = 96;
    double penumbra_px, middle_px;
    std::vector<float> truth;
    std::vector<uint8_t> counted;
    std::vector<std::vector<float>> images;

    // Light on the right and below; `middle_px` across the edge from the image's centre towards the light.
    explicit PenumbraImages(double penumbra = 48, double middle = 0)
        : penumbra_px(penumbra), middle_px(middle), counted(size_t{width} * height, 1) {
        for (uint32_t y = 0; y < height; ++y)
            for (uint32_t x = 0; x < width; ++x) truth.push_back(static_cast<float>(exact(x, y, 0)));
    }
    // With the edge moved on by `shift` pixels towards the light.
    double exact(uint32_t x, uint32_t y, double shift) const {
        const double across = (x + 0.5 - width / 2.0) * 0.94 + (y + 0.5 - height / 2.0) * 0.341;
        return half_plane_visibility(0.01 * 2 * (across - middle_px - shift) / penumbra_px, 0.01);
    }
    template <class Make>
    void add_images(int count, Make make) {
        for (int i = 0; i < count; ++i) {
            std::mt19937 random(static_cast<uint32_t>(100 + images.size()));
            std::vector<float> image;
            for (const float v : truth)
                image.push_back(static_cast<float>(make(static_cast<double>(v), random)));
            images.push_back(std::move(image));
        }
    }
    void add_rays(int count, int rays) {
        add_images(count, [rays](double v, auto& random) { return mean_of_rays(v, random, rays); });
    }
    ComparedFrame frame() const {
        ComparedFrame frame{width, height, truth, counted, {}};
        for (const std::vector<float>& image : images) frame.seeds.emplace_back(image);
        return frame;
    }
};

}  // namespace penumbra::test
