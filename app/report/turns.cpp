// SPDX-License-Identifier: MIT
#include "app/report/turns.h"

#include <numeric>

namespace penumbra::report {

std::optional<Estimate> Costs::sum(std::optional<double> PassCost::*figure, bool mask_only) const {
    std::vector<double> sums;
    for (const std::vector<PassCost>& frame : frames) {
        double total = 0;
        for (size_t p = 0; p < frame.size(); ++p) {
            if (mask_only && !passes[p].mask) continue;
            if (!(frame[p].*figure)) return std::nullopt;
            total += *(frame[p].*figure);
        }
        sums.push_back(total);
    }
    return median_of(std::move(sums));
}

std::optional<Estimate> Costs::pass(size_t index, std::optional<double> PassCost::*figure) const {
    std::vector<double> samples;
    for (const std::vector<PassCost>& frame : frames)
        if (const auto& value = frame[index].*figure) samples.push_back(*value);
    return median_of(std::move(samples));
}

Turns::Turns(const std::vector<std::unique_ptr<Runner>>& runners, size_t contenders,
             const TurnsOptions& options, const std::function<void()>& step)
    : costs_(contenders) {
    for (uint32_t seed = 1; seed <= options.seeds; ++seed) {
        for (const auto& runner : runners) runner->set_seed(seed);
        for (uint32_t frame = 0; frame < options.frames; ++frame) {
            for (size_t turn = 0; turn < runners.size(); ++turn) {
                Runner& runner = *runners[(turn + frame) % runners.size()];
                for (Sample& sample : runner.run(frame, frame == 0, options.judged.contains(frame)))
                    keep(std::move(sample), runner, frame, options);
            }
            step();
        }
    }
}

void Turns::keep(Sample sample, const Runner& runner, uint32_t frame, const TurnsOptions& options) {
    if (frame >= options.warm_up) {
        Costs& costs = costs_[sample.contender];
        costs.passes = runner.passes();
        costs.frames.push_back(std::move(sample.passes));
        costs.rays.push_back(static_cast<double>(sample.rays));
    }
    if (options.judged.contains(frame))
        masks_[{sample.contender, frame}].push_back(std::move(sample.visibility));
}

}  // namespace penumbra::report
