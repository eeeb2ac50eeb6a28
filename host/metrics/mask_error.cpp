// SPDX-License-Identifier: MIT
// A value that is not a number counts as the worst error that its pixel can have, so that it can never help a
// score.
#include "host/metrics/mask_error.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>

namespace penumbra {
namespace {

constexpr double leak_above = 0.05, acne_below = 0.95;

void add(ErrorSum& sum, const ErrorSum& other) {
    sum.pixels += other.pixels;
    sum.squares += other.squares;
}

// The seeds' values at one pixel.
struct PixelErrors {
    double squares = 0, mean = 0, variance = 0;
};

PixelErrors errors_at(const ComparedFrame& frame, size_t pixel, MetricSums& sums) {
    const double truth = static_cast<double>(frame.truth[pixel]), worst = truth > 0.5 ? -truth : 1 - truth;
    const auto count = static_cast<double>(frame.seeds.size());
    PixelErrors out;
    double squares = 0;
    for (const std::span<const float> seed : frame.seeds) {
        const double value = static_cast<double>(seed[pixel]);
        const double error = std::isfinite(value) ? value - truth : worst;
        out.mean += error / count;
        squares += error * error;
        sums.max_abs = std::max(sums.max_abs, std::abs(error));
        sums.leaks += truth < penumbra_eps && !(truth + error <= leak_above);
        sums.acne += truth > 1 - penumbra_eps && !(truth + error >= acne_below);
    }
    out.squares = squares / count;
    if (count > 1) out.variance = std::max(squares - count * out.mean * out.mean, 0.0) / (count - 1);
    return out;
}

std::optional<double> root_mean(const ErrorSum& sum) {
    if (sum.pixels == 0) return std::nullopt;
    return std::sqrt(sum.squares / static_cast<double>(sum.pixels));
}

std::optional<double> ratio(double a, double b) {
    if (!(a > 0 && b > 0)) return std::nullopt;
    return a / b;
}

// Percentile bootstrap over blocks (Efron 1979), from a fixed seed: the same images give the same interval.
std::optional<std::array<double, 2>> confidence(std::span<const MetricSums::Block> blocks) {
    std::vector<MetricSums::Block> used;
    for (const MetricSums::Block& block : blocks)
        if (block.signal > 0 || block.squares != 0) used.push_back(block);
    constexpr size_t fewest = 4, draws = 1000;
    if (used.size() < fewest) return std::nullopt;
    std::mt19937 random(1);
    std::uniform_int_distribution<size_t> any(0, used.size() - 1);
    std::vector<double> values;
    for (size_t draw = 0; draw < draws; ++draw) {
        MetricSums::Block sum;
        for (size_t i = 0; i < used.size(); ++i) {
            const MetricSums::Block& block = used[any(random)];
            sum.signal += block.signal;
            sum.squares += block.squares;
        }
        if (sum.squares > 0) values.push_back(sum.signal / sum.squares);
    }
    if (values.size() < draws) return std::nullopt;
    std::sort(values.begin(), values.end());
    return std::array{values[draws * 25 / 1000], values[draws * 975 / 1000 - 1]};
}

}  // namespace

void MetricSums::add(const MetricSums& other) {
    penumbra::add(penumbra, other.penumbra);
    penumbra::add(lit, other.lit);
    penumbra::add(umbra, other.umbra);
    signal += other.signal;
    variance += other.variance;
    mean_errors += other.mean_errors;
    reference += other.reference;
    reference_penumbra += other.reference_penumbra;
    max_abs = std::max(max_abs, other.max_abs);
    leaks += other.leaks;
    acne += other.acne;
    nonfinite += other.nonfinite;
    seeds = std::max(seeds, other.seeds);
    blocks.insert(blocks.end(), other.blocks.begin(), other.blocks.end());
}

void MetricSums::add_correlated(const MetricSums& other) {
    if (blocks.size() < other.blocks.size())
        throw std::invalid_argument("add_correlated: no frame of this size before");
    const size_t first = blocks.size() - other.blocks.size();
    add(other);
    for (size_t i = 0; i < other.blocks.size(); ++i) {
        blocks[first + i].signal += other.blocks[i].signal;
        blocks[first + i].squares += other.blocks[i].squares;
    }
    blocks.resize(first + other.blocks.size());
}

void MetricSums::add_frame(uint32_t frame, const MetricSums& other) {
    if (block_frame && frame < *block_frame + metric_block_frames) {
        add_correlated(other);
    } else {
        add(other);
        block_frame = frame;
    }
}

void check_sizes(const ComparedFrame& frame, const char* caller) {
    const size_t pixels = frame.pixels();
    bool fits = frame.truth.size() == pixels && frame.counted.size() == pixels && !frame.seeds.empty() &&
                (frame.reference_rays.empty() || frame.reference_rays.size() == pixels);
    for (const std::span<const float> seed : frame.seeds) fits = fits && seed.size() == pixels;
    if (!fits) throw std::invalid_argument(std::string(caller) + ": images of different sizes");
}

// Strata that the shadow's edge does not cross count exactly, so stratified rays beat v(1 - v) / n: one edge
// crosses a few sqrt(n) of n strata, each of which leaves a sixth / n^2. Over the disc's penumbra the mean is
// .154 n^-1.5 where that of v(1 - v) is .144, for strata that a concentric map makes (measured from 64 to
// 4096 rays; a polar map's, long and thin, leave .246). Several edges within one sun leave more than this, so
// that too little is taken out and never too much.
double reference_variance(double truth, double rays) {
    if (!(rays > 0)) return 0;
    return 1.07 * truth * (1 - truth) * std::pow(rays, -1.5);
}

MetricSums measure(const ComparedFrame& frame) {
    check_sizes(frame, "measure");
    const size_t pixels = frame.pixels();
    MetricSums sums;
    sums.seeds = frame.seeds.size();
    const uint32_t across = (frame.width + metric_block_px - 1) / metric_block_px;
    sums.blocks.resize(size_t{across} * ((frame.height + metric_block_px - 1) / metric_block_px));
    for (size_t pixel = 0; pixel < pixels; ++pixel) {
        for (const std::span<const float> seed : frame.seeds) sums.nonfinite += !std::isfinite(seed[pixel]);
        if (!frame.counted[pixel]) continue;
        const PixelErrors errors = errors_at(frame, pixel, sums);
        const double truth = static_cast<double>(frame.truth[pixel]);
        const bool lit = truth > 1 - penumbra_eps, umbra = truth < penumbra_eps;
        add(lit ? sums.lit : umbra ? sums.umbra : sums.penumbra, {1, errors.squares});
        const double signal = lit || umbra ? 0 : truth * (1 - truth);
        sums.signal += signal;
        sums.variance += errors.variance;
        sums.mean_errors += errors.mean * errors.mean;
        const double reference =
            frame.reference_rays.empty()
                ? 0
                : reference_variance(truth, static_cast<double>(frame.reference_rays[pixel]));
        sums.reference += reference;
        if (!lit && !umbra) sums.reference_penumbra += reference;
        const size_t y = pixel / frame.width, x = pixel % frame.width;
        MetricSums::Block& block = sums.blocks[y / metric_block_px * across + x / metric_block_px];
        block.signal += signal;
        block.squares += errors.squares - reference;
    }
    return sums;
}

MaskMetrics metrics_of(const MetricSums& sums) {
    ErrorSum all = sums.penumbra;
    add(all, sums.lit);
    add(all, sums.umbra);

    MaskMetrics out;
    out.receivers = all.pixels;
    out.penumbra = sums.penumbra.pixels;
    out.lit = sums.lit.pixels;
    out.umbra = sums.umbra.pixels;
    out.rmse_all = root_mean(all);
    out.rmse_penumbra = root_mean(sums.penumbra);
    out.rmse_lit = root_mean(sums.lit);
    out.rmse_umbra = root_mean(sums.umbra);
    if (out.rmse_all && *out.rmse_all > 0) out.psnr_db = -20 * std::log10(*out.rmse_all);
    if (all.pixels > 0) out.max_abs = sums.max_abs;
    out.n_eff = ratio(sums.signal, all.squares - sums.reference);
    out.n_eff_penumbra = ratio(sums.signal, sums.penumbra.squares - sums.reference_penumbra);
    out.n_eff_ci95 = confidence(sums.blocks);
    const auto seeds = static_cast<double>(sums.seeds);
    if (sums.seeds > 1) {
        out.n_variance = ratio(sums.signal, sums.variance);
        out.n_bias = ratio(sums.signal, sums.mean_errors - sums.variance / seeds - sums.reference);
    }
    if (sums.umbra.pixels > 0)
        out.leak = static_cast<double>(sums.leaks) / (static_cast<double>(sums.umbra.pixels) * seeds);
    if (sums.lit.pixels > 0)
        out.acne = static_cast<double>(sums.acne) / (static_cast<double>(sums.lit.pixels) * seeds);
    out.nonfinite = sums.nonfinite;
    return out;
}

}  // namespace penumbra
