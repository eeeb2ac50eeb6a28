// SPDX-License-Identifier: MIT
#include "app/report/statistics.h"

#include <algorithm>
#include <cmath>

namespace penumbra::report {
namespace {

// The largest k such that at most k of n fair coins show heads with a probability of no more than 2.5 %; the
// interval is then from the (k + 1)th smallest sample to the (k + 1)th largest. Nothing where even k = 0 is
// likelier.
std::optional<size_t> outer_rank(size_t n) {
    constexpr double tail = 0.025;
    double log_term = -static_cast<double>(n) * std::log(2.0), sum = 0;
    std::optional<size_t> rank;
    for (size_t k = 0; k < n / 2; ++k) {
        sum += std::exp(log_term);
        if (sum > tail) break;
        rank = k;
        log_term += std::log(static_cast<double>(n - k)) - std::log(static_cast<double>(k + 1));
    }
    return rank;
}

}  // namespace

std::optional<Estimate> median_of(std::vector<double> samples) {
    if (samples.empty()) return std::nullopt;
    std::sort(samples.begin(), samples.end());
    const size_t n = samples.size();
    Estimate estimate{(samples[(n - 1) / 2] + samples[n / 2]) / 2, {}, {}};
    if (const auto rank = outer_rank(n)) {
        estimate.low = samples[*rank];
        estimate.high = samples[n - 1 - *rank];
    }
    return estimate;
}

}  // namespace penumbra::report
