// SPDX-License-Identifier: MIT
// Formulas and constants of the published form; borders as published: what lies outside the image counts as
// nothing.
#include "tests/denoiser_model.h"

#include <algorithm>
#include <cmath>

namespace penumbra::model {
namespace {

size_t at(const DenoiserInputs& in, int x, int y) {
    return static_cast<size_t>(y) * in.width + x;
}
bool inside(const DenoiserInputs& in, int x, int y) {
    return x >= 0 && y >= 0 && x < in.width && y < in.height;
}
int blocks_across(const DenoiserInputs& in) {
    return (in.width + 7) / 8;
}
int blocks_down(const DenoiserInputs& in) {
    return (in.height + 7) / 8;
}
size_t block_of(const DenoiserInputs& in, int x, int y) {
    return static_cast<size_t>(y / 8) * blocks_across(in) + x / 8;
}

BlockState block_state(const DenoiserInputs& in, int bx, int by) {
    bool any_lit = false, any_dark = false, any_receiver = false;
    for (int y = 8 * by - 8; y < 8 * by + 16; ++y)
        for (int x = 8 * bx - 8; x < 8 * bx + 16; ++x) {
            if (!inside(in, x, y)) continue;
            (in.lit[at(in, x, y)] ? any_lit : any_dark) = true;
            if (x / 8 == bx && y / 8 == by && x >= 0 && y >= 0)
                any_receiver |= in.view_depth[at(in, x, y)] > 0;
        }
    if (!any_receiver || !any_lit) return BlockState::shadowed;
    return any_dark ? BlockState::work : BlockState::lit;
}

// Weighted by exp(-3 d^2 / 81) per axis, over the constant sum of all weights.
double local_mean(const DenoiserInputs& in, int px, int py) {
    static const std::array<double, 17> weight = [] {
        std::array<double, 17> w{};
        for (int i = -8; i <= 8; ++i) w[static_cast<size_t>(i + 8)] = std::exp(-3.0 * i * i / 81.0);
        return w;
    }();
    double all = 0, sum = 0;
    for (double w : weight) all += w;
    for (int dy = -8; dy <= 8; ++dy)
        for (int dx = -8; dx <= 8; ++dx)
            if (inside(in, px + dx, py + dy) && in.lit[at(in, px + dx, py + dy)])
                sum += weight[static_cast<size_t>(dx + 8)] * weight[static_cast<size_t>(dy + 8)];
    return sum / (all * all);
}

// The motion of the nearest receiver of the 2x2 quad; of the pixel itself where several are as near.
std::array<double, 2> quad_motion(const DenoiserInputs& in, int x, int y) {
    size_t nearest = at(in, x, y);
    for (int i = 0; i < 4; ++i) {
        const int qx = x / 2 * 2 + i % 2, qy = y / 2 * 2 + i / 2;
        if (!inside(in, qx, qy)) continue;
        const double z = in.view_depth[at(in, qx, qy)];
        if (z > 0 && z < in.view_depth[nearest]) nearest = at(in, qx, qy);
    }
    return in.motion[nearest];
}

double bilinear(const DenoiserInputs& in, const Image<Signal>& image, double u, double v) {
    const double x = std::clamp(u * in.width - 0.5, 0.0, in.width - 1.0);
    const double y = std::clamp(v * in.height - 0.5, 0.0, in.height - 1.0);
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const int x1 = std::min(x0 + 1, in.width - 1), y1 = std::min(y0 + 1, in.height - 1);
    const auto value = [&](int column, int row) { return image[at(in, column, row)].visibility; };
    return std::lerp(std::lerp(value(x0, y0), value(x1, y0), x - x0),
                     std::lerp(value(x0, y1), value(x1, y1), x - x0), y - y0);
}

Signal stored(const Signal& s, Storage storage) {
    return {round_to_float(s.visibility, 10, storage), round_to_float(s.variance, 10, storage)};
}
Moments stored(const Moments& m, Storage storage) {
    return {round_to_float(m.mean, 6, storage), round_to_float(m.deviations, 6, storage),
            round_to_float(m.count, 5, storage)};
}

struct Accumulated {
    Signal signal;
    Moments moments;
};

Accumulated accumulate(const DenoiserInputs& in, const DenoiserState& before,
                       const DenoiserSettings& settings, int x, int y, double mean) {
    const double bit = in.lit[at(in, x, y)];
    const auto motion = quad_motion(in, x, y);
    const double u = (x + 0.5) / in.width + motion[0], v = (y + 0.5) / in.height + motion[1];
    const bool finite = std::abs(u) < 1e6 && std::abs(v) < 1e6;

    Moments m;
    if (!in.reset && finite && u > 0 && v > 0 && u < 1 && v < 1) {
        const size_t there = at(in, static_cast<int>(u * in.width), static_cast<int>(v * in.height));
        const double expected = in.expected_depth[at(in, x, y)];
        const double grazing = std::pow(1 - std::clamp(in.facing[at(in, x, y)], 0.0, 1.0), 8);
        const double tolerance = std::lerp(0.01, 0.1, grazing);
        if (std::abs(before.view_depth[there] - expected) < tolerance * expected) m = before.moments[there];
    }
    const double old_mean = m.mean;
    m.count += 1;
    m.mean += (bit - m.mean) / m.count;
    m.deviations += (bit - old_mean) * (bit - m.mean);
    double variance = m.count > 1 ? m.deviations / (m.count - 1) : 1;

    const double spatial_variance = std::max(mean - mean * mean, 0.0);
    const double half_box = settings.clamp_sigma * std::sqrt(spatial_variance);
    double history = bit;
    if (!in.reset)
        history = finite ? bilinear(in, before.history, u, v)
                         : bilinear(in, before.history, (x + 0.5) / in.width, (y + 0.5) / in.height);
    m.count *= std::exp(-std::pow((history - mean) / std::max(half_box, 0.001), 2) / 20);
    if (m.count < 16) variance = std::max(variance, spatial_variance) * std::max(16 - m.count, 1.0);

    const double alpha = std::lerp(0.05, 1.0, std::sqrt(std::max(8 - m.count, 0.0) / 8));
    const double clamped = std::clamp(history, mean - half_box, mean + half_box);
    return {{std::lerp(clamped, bit, alpha), variance}, m};
}

Signal filter_at(const DenoiserInputs& in, const Image<Signal>& signal, int step, int px, int py) {
    const Signal centre = signal[at(in, px, py)];
    double blurred = 0;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if (inside(in, px + dx, py + dy))
                blurred += (2 - std::abs(dx)) * (2 - std::abs(dy)) / 16.0 *
                           signal[at(in, px + dx, py + dy)].variance;
    const double sigma = std::sqrt(std::max(blurred + 1e-9, 0.0));

    const auto unit_dot = [&](size_t a, size_t b) {
        const auto& n = in.normal[a];
        const auto& m = in.normal[b];
        const double dot = n[0] * m[0] + n[1] * m[1] + n[2] * m[2];
        const double lengths = std::hypot(n[0], n[1], n[2]) * std::hypot(m[0], m[1], m[2]);
        return lengths > 0 ? std::clamp(dot / lengths, 0.0, 1.0) : 0.0;
    };
    double sum = centre.visibility, sum_variance = centre.variance, weights = 1;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            const int qx = px + step * dx, qy = py + step * dy;
            if ((dx == 0 && dy == 0) || !inside(in, qx, qy) || !(in.view_depth[at(in, qx, qy)] > 0)) continue;
            const Signal& tap = signal[at(in, qx, qy)];
            const double w =
                (dx ? 2.0 / 3 : 1) * (dy ? 2.0 / 3 : 1) *
                std::exp(-std::abs(centre.visibility - tap.visibility) / sigma) *
                std::exp(-std::abs(in.view_depth[at(in, px, py)] - in.view_depth[at(in, qx, qy)])) *
                std::pow(unit_dot(at(in, px, py), at(in, qx, qy)), 32);
            sum += w * tap.visibility;
            sum_variance += w * w * tap.variance;
            weights += w;
        }
    return {sum / weights, sum_variance / (weights * weights)};
}

}  // namespace

double round_to_float(double x, int mantissa_bits, Storage storage) {
    if (storage == Storage::exact || !(x > 0)) return x;
    const int exponent = std::max(std::ilogb(x), -14);  // below: denormal numbers share the last exponent
    const double ulp = std::ldexp(1.0, exponent - mantissa_bits);
    return (storage == Storage::nearest ? std::nearbyint(x / ulp) : std::trunc(x / ulp)) * ulp;
}

DenoiserInputs flat_receiver(int width, int height) {
    const size_t n = static_cast<size_t>(width) * height;
    return {width,
            height,
            Image<uint8_t>(n, 0),
            Image<double>(n, 10.0),
            Image<double>(n, 10.0),
            Image<std::array<double, 3>>(n, {0, 0, 1}),
            Image<double>(n, 1.0),
            Image<std::array<double, 2>>(n, {0, 0}),
            false};
}

DenoiserFrame classify_tiles(const DenoiserInputs& in, const DenoiserState& before,
                             const DenoiserSettings& settings) {
    DenoiserFrame out;
    const size_t n = static_cast<size_t>(in.width) * in.height;
    out.mean.resize(n);
    out.reprojected.resize(n);
    out.moments.resize(n);
    for (int by = 0; by < blocks_down(in); ++by)
        for (int bx = 0; bx < blocks_across(in); ++bx) out.tile_meta.push_back(block_state(in, bx, by));

    for (int y = 0; y < in.height; ++y)
        for (int x = 0; x < in.width; ++x) {
            const size_t p = at(in, x, y);
            const bool receiver = in.view_depth[p] > 0;
            const BlockState state = out.tile_meta[block_of(in, x, y)];
            Accumulated a;
            if (state != BlockState::work) {
                const double v = state == BlockState::lit ? 1 : 0;
                a = {{v, 0}, {v, 0, receiver ? 1.0 : 0.0}};
            } else {
                out.mean[p] = local_mean(in, x, y);
                if (receiver) a = accumulate(in, before, settings, x, y, out.mean[p]);
            }
            out.reprojected[p] = stored(a.signal, settings.storage);
            out.moments[p] = stored(a.moments, settings.storage);
        }
    return out;
}

Image<Signal> filter(const DenoiserInputs& in, const std::vector<BlockState>& tile_meta,
                     const Image<Signal>& signal, int step, Storage storage) {
    Image<Signal> out(signal.size());
    for (int y = 0; y < in.height; ++y)
        for (int x = 0; x < in.width; ++x) {
            const BlockState state = tile_meta[block_of(in, x, y)];
            Signal& s = out[at(in, x, y)];
            s.visibility = state == BlockState::lit ? 1 : 0;
            if (state == BlockState::work && in.view_depth[at(in, x, y)] > 0)
                s = filter_at(in, signal, step, x, y);
            s = stored(s, storage);
        }
    return out;
}

double with_contrast(const Signal& signal) {
    return std::pow(std::abs(signal.visibility), std::max(1.2 - signal.variance, 1.0));
}

DenoiserFrame denoise(const DenoiserInputs& in, DenoiserState& state, const DenoiserSettings& settings) {
    DenoiserFrame frame = classify_tiles(in, state, settings);
    frame.filtered0 = filter(in, frame.tile_meta, frame.reprojected, 1, settings.storage);
    frame.filtered1 = filter(in, frame.tile_meta, frame.filtered0, 2, settings.storage);
    frame.filtered2 = filter(in, frame.tile_meta, frame.filtered1, 4, Storage::exact);
    for (const Signal& s : frame.filtered2) {
        const double v = settings.contrast ? with_contrast(s) : s.visibility;
        frame.visibility.push_back(settings.storage == Storage::exact ? v : std::round(v * 255) / 255);
    }
    state = {in.view_depth, frame.moments, frame.filtered0};
    return frame;
}

}  // namespace penumbra::model
