// SPDX-License-Identifier: MIT
// Errors of a visibility mask, pixel by pixel. Everything is a sum over pixels, frames and seeds, kept apart
// from the ratios made of it: a pooled ratio is wanted, never a mean of ratios.
//
// The headline is the effective number of samples per pixel: plain Monte Carlo with N rays in every pixel has
// the mean squared error v(1 - v) / N, so an image's N_eff is the sum of v(1 - v) over the penumbra divided
// by all of its squared errors, those beside the penumbra included.
#pragma once

#include <array>
#include <optional>

#include "host/metrics/compared_frame.h"

namespace penumbra {

// Errors nearer than this, in pixels and in frames, are not independent of each other.
constexpr uint32_t metric_block_px = 32, metric_block_frames = 32;

struct ErrorSum {
    uint64_t pixels = 0;
    double squares = 0;  // of the errors, averaged over the seeds
};

struct MetricSums {
    ErrorSum penumbra, lit, umbra;
    double signal = 0;              // v(1 - v) over the penumbra
    double variance = 0;            // unbiased, between seeds; meaningful from two on
    double mean_errors = 0;         // squares of the mean image's errors
    double reference = 0;           // the part of either that is the truth's own noise
    double reference_penumbra = 0;  // of that, what is in the penumbra
    double max_abs = 0;
    uint64_t leaks = 0, acne = 0;  // pixel and seed pairs
    uint64_t nonfinite = 0;        // texels of the whole images
    size_t seeds = 0;
    struct Block {
        double signal = 0, squares = 0;
    };
    std::vector<Block> blocks;            // for the interval of confidence
    std::optional<uint32_t> block_frame;  // with which the last group of dependent frames began

    void add(const MetricSums& other);
    // Of a frame so near in time that its blocks are the last frame's blocks once more.
    void add_correlated(const MetricSums& other);
    // Either, by a frame's number; numbers rise.
    void add_frame(uint32_t frame, const MetricSums& other);
};

MetricSums measure(const ComparedFrame& frame);

// Expected square of a truth's own error where `rays` stratified rays have counted it.
double reference_variance(double truth, double rays);

// Absent where there is nothing to divide by. The truth's own noise is taken out of the effective samples,
// not out of the root mean squares, which are the images' as they are.
struct MaskMetrics {
    uint64_t receivers = 0, penumbra = 0, lit = 0, umbra = 0;  // pixels times frames
    std::optional<double> rmse_all, rmse_penumbra, rmse_lit, rmse_umbra, psnr_db, max_abs;
    std::optional<double> n_eff, n_eff_penumbra;
    std::optional<double> n_variance, n_bias;  // 1 / n_eff = 1 / n_variance + 1 / n_bias; two seeds or more
    std::optional<std::array<double, 2>> n_eff_ci95;
    std::optional<double> leak, acne;
    uint64_t nonfinite = 0;
};

MaskMetrics metrics_of(const MetricSums& sums);

}  // namespace penumbra
