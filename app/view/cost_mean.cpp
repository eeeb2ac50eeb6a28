// SPDX-License-Identifier: MIT
#include "app/view/cost_mean.h"

#include <utility>

namespace penumbra::viewer {
namespace {

std::optional<double> blended(const std::optional<double>& mean, const std::optional<double>& value) {
    return mean && value ? 0.85 * *mean + 0.15 * *value : value ? value : mean;
}

}  // namespace

void CostMean::add(std::vector<PassCost> passes, double cpu_ms) {
    if (++frames_ > 2) {
        cpu_ms = *blended(cpu_ms_, cpu_ms);
        for (size_t p = 0; p < passes.size() && p < passes_.size(); ++p) {
            passes[p].ms = blended(passes_[p].ms, passes[p].ms);
            passes[p].cpu_ms = blended(passes_[p].cpu_ms, passes[p].cpu_ms);
        }
    }
    passes_ = std::move(passes);
    cpu_ms_ = cpu_ms;
}

}  // namespace penumbra::viewer
