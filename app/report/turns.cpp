// SPDX-License-Identifier: MIT
#include "app/report/turns.h"

#include <algorithm>
#include <stdexcept>

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

Turns::Turns(const std::vector<std::unique_ptr<Runner>>& runners, const TurnsOptions& options,
             const std::function<void()>& step)
    : options_(options), costs_(runners.size()) {
    const auto needed = [&](const Runner& runner, uint32_t frame, uint32_t seed) {
        if (runner.has_history()) return true;
        if (options.still) return frame + 2 >= options.frames;
        if (options.judged.contains(frame)) return true;
        if (!options.costs || seed != 1 || runner.cost_memory() == CostMemory::none) return false;
        return runner.cost_memory() == CostMemory::all || options.judged.contains(frame + 1);
    };
    for (size_t contender = 0; contender < runners.size(); ++contender) originals_.push_back(contender);
    for (uint32_t seed = 1; seed <= options.seeds; ++seed) {
        for (const auto& runner : runners) runner->set_seed(seed);
        for (uint32_t frame = 0; frame < options.frames; ++frame) {
            for (size_t turn = 0; turn < runners.size(); ++turn) {
                const size_t contender = (turn + frame) % runners.size();
                Runner& runner = *runners[contender];
                if (originals_[contender] == contender && needed(runner, frame, seed))
                    keep(contender, runner.run(frame, frame == 0, options.judged.contains(frame)), runner,
                         frame);
            }
            step();
        }
        if (seed == 1) find_originals(runners);
    }
}

void Turns::keep(size_t contender, Sample sample, const Runner& runner, uint32_t frame) {
    if (frame >= options_.warm_up && sample.true_cost) {
        Costs& costs = costs_[contender];
        costs.passes = runner.passes();
        costs.frames.push_back(std::move(sample.passes));
        costs.rays.push_back(static_cast<double>(sample.rays));
        if (sample.maps_cpu_ms) costs.maps_cpu_ms.push_back(*sample.maps_cpu_ms);
    }
    if (!sample.visibility.empty()) masks_[{contender, frame}].push_back(std::move(sample.visibility));
}

const Turns::Masks& Turns::masks(size_t contender, uint32_t frame) const {
    const auto found = masks_.find({originals_[contender], frame});
    if (found != masks_.end()) return found->second;
    if (!options_.still) throw std::logic_error("a mask that was not judged");
    return masks_.at({originals_[contender], options_.frames - 1});
}

void Turns::find_originals(const std::vector<std::unique_ptr<Runner>>& runners) {
    const auto same = [&](size_t a, size_t b) {
        return std::ranges::all_of(options_.judged,
                                   [&](uint32_t frame) { return masks(a, frame) == masks(b, frame); });
    };
    std::vector<size_t> by_passes = originals_, found;
    std::ranges::stable_sort(by_passes, {}, [&](size_t c) { return runners[c]->passes().size(); });
    std::vector<size_t> originals = originals_;
    for (const size_t contender : by_passes) {
        const auto original = std::ranges::find_if(found, [&](size_t f) { return same(f, contender); });
        if (original != found.end())
            originals[contender] = *original;
        else
            found.push_back(contender);
    }
    originals_ = std::move(originals);
}

}  // namespace penumbra::report
