// SPDX-License-Identifier: MIT
// Structural similarity of visibility (Wang, Bovik, Sheikh, Simoncelli 2004): 11x11 Gaussian window of sigma
// 1.5, K1 = .01, K2 = .03, range 1. Away from shadow edges a mask is constant and the index degenerates to 1,
// so only pixels within 8 of the penumbra (Chebyshev distance) are averaged.
#pragma once

#include <optional>

#include "host/metrics/compared_frame.h"

namespace penumbra {

struct SsimSum {
    double sum = 0;       // of the index, averaged over the seeds
    uint64_t pixels = 0;  // near the penumbra

    void add(const SsimSum& other) {
        sum += other.sum;
        pixels += other.pixels;
    }
    std::optional<double> mean() const {
        return pixels ? std::optional(sum / static_cast<double>(pixels)) : std::nullopt;
    }
};

SsimSum ssim_near_penumbra(const ComparedFrame& frame);

}  // namespace penumbra
