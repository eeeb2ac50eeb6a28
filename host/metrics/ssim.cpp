// SPDX-License-Identifier: MIT
// Windows are cut at the image's border and their weights normalised again. Values that are not numbers count
// as the worst possible ones.
#include "host/metrics/ssim.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace penumbra {
namespace {

constexpr int window_reach = 5, penumbra_reach = 8;
constexpr double sigma = 1.5, c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;

std::array<double, 2 * window_reach + 1> gaussian() {
    std::array<double, 2 * window_reach + 1> weights{};
    for (int i = -window_reach; i <= window_reach; ++i)
        weights[static_cast<size_t>(i + window_reach)] = std::exp(-0.5 * i * i / (sigma * sigma));
    return weights;
}

// Weighted sums over a window, along one axis and then the other.
struct Moments {
    double weight = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;

    void add(const Moments& m, double w) {
        weight += w * m.weight;
        a += w * m.a;
        b += w * m.b;
        aa += w * m.aa;
        bb += w * m.bb;
        ab += w * m.ab;
    }
};

std::vector<Moments> blur(const std::vector<Moments>& in, uint32_t width, uint32_t height, bool along_x) {
    static const auto weights = gaussian();
    std::vector<Moments> out(in.size());
    const int limit = static_cast<int>(along_x ? width : height);
    const size_t stride = along_x ? 1 : width;
    for (size_t p = 0; p < in.size(); ++p) {
        const int at = static_cast<int>(along_x ? p % width : p / width);
        for (int i = std::max(-window_reach, -at); i <= std::min(window_reach, limit - 1 - at); ++i)
            out[p].add(in[p + static_cast<size_t>(i) * stride],
                       weights[static_cast<size_t>(i + window_reach)]);
    }
    return out;
}

double index_of(const Moments& m) {
    const double a = m.a / m.weight, b = m.b / m.weight;
    const double aa = std::max(m.aa / m.weight - a * a, 0.0), bb = std::max(m.bb / m.weight - b * b, 0.0),
                 ab = m.ab / m.weight - a * b;
    return (2 * a * b + c1) * (2 * ab + c2) / ((a * a + b * b + c1) * (aa + bb + c2));
}

// Pixels within penumbra_reach of one in penumbra, in either axis.
std::vector<uint8_t> near_penumbra(const ComparedFrame& frame) {
    const auto spread = [&](const std::vector<uint8_t>& in, bool along_x) {
        std::vector<uint8_t> out(in.size(), 0);
        const int limit = static_cast<int>(along_x ? frame.width : frame.height);
        const size_t stride = along_x ? 1 : frame.width;
        for (size_t p = 0; p < in.size(); ++p) {
            if (!in[p]) continue;
            const int at = static_cast<int>(along_x ? p % frame.width : p / frame.width);
            for (int i = std::max(-penumbra_reach, -at); i <= std::min(penumbra_reach, limit - 1 - at); ++i)
                out[p + static_cast<size_t>(i) * stride] = 1;
        }
        return out;
    };
    std::vector<uint8_t> inside(frame.pixels());
    for (size_t p = 0; p < inside.size(); ++p)
        inside[p] = frame.counted[p] && in_penumbra(static_cast<double>(frame.truth[p]));
    return spread(spread(inside, true), false);
}

}  // namespace

SsimSum ssim_near_penumbra(const ComparedFrame& frame) {
    check_sizes(frame, "ssim_near_penumbra");
    const std::vector<uint8_t> near = near_penumbra(frame);
    SsimSum sum;
    for (size_t p = 0; p < near.size(); ++p) sum.pixels += near[p] && frame.counted[p];
    for (const std::span<const float> seed : frame.seeds) {
        std::vector<Moments> moments(frame.pixels());
        for (size_t p = 0; p < moments.size(); ++p) {
            const auto truth = static_cast<double>(frame.truth[p]), value = static_cast<double>(seed[p]);
            const double finite = std::isfinite(value) ? value : truth > 0.5 ? 0 : 1;
            moments[p] = {1, truth, finite, truth * truth, finite * finite, truth * finite};
        }
        moments = blur(blur(moments, frame.width, frame.height, true), frame.width, frame.height, false);
        for (size_t p = 0; p < moments.size(); ++p)
            if (near[p] && frame.counted[p])
                sum.sum += index_of(moments[p]) / static_cast<double>(frame.seeds.size());
    }
    return sum;
}

}  // namespace penumbra
