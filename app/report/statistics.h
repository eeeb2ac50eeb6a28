// SPDX-License-Identifier: MIT
// Medians with intervals that assume nothing of the distribution: timings on a shared machine have long
// tails. The interval is that of order statistics: the number of samples below the true median is binomial(n,
// 1/2) (David and Nagaraja, Order Statistics, 7.1).
#pragma once

#include <optional>
#include <vector>

namespace penumbra::report {

struct Estimate {
    double median = 0;
    // 95 %; absent where so few samples cannot give one (fewer than six).
    std::optional<double> low, high;
};

// Nothing for no samples. The median of an even number is the mean of the middle two.
std::optional<Estimate> median_of(std::vector<double> samples);

}  // namespace penumbra::report
