// SPDX-License-Identifier: MIT
#include "app/report/turns.h"

#include <algorithm>
#include <stdexcept>

namespace penumbra::report {

namespace {

void take_least(std::optional<double>& least, const std::optional<double>& value) {
    if (value) least = std::min(least.value_or(*value), *value);
}

}  // namespace

bool takes_turn(const TurnsOptions& options, const Runner& runner, bool original, uint32_t round,
                uint32_t frame) {
    const bool judges = original && round < options.seeds, times = round < options.timings;
    if (!judges && !times) return false;
    if (runner.has_history()) return true;
    if (options.still) return frame + 2 >= options.frames;
    if (judges && options.judged.contains(frame)) return true;
    if (!times || options.timed.empty()) return false;
    if (options.timed.contains(frame)) return true;
    if (runner.cost_memory() == CostMemory::all) return frame < *options.timed.rbegin();
    return runner.cost_memory() == CostMemory::frame_before && options.timed.contains(frame + 1);
}

void Costs::add(uint32_t frame, Sample sample) {
    const auto [place, first] = frames.try_emplace(frame);
    FrameCosts& costs = place->second;
    costs.rays = static_cast<double>(sample.rays);
    take_least(costs.maps_cpu_ms, sample.maps_cpu_ms);
    if (first) costs.passes = std::move(sample.passes);
    for (size_t p = 0; p < sample.passes.size(); ++p) {
        take_least(costs.passes[p].ms, sample.passes[p].ms);
        take_least(costs.passes[p].cpu_ms, sample.passes[p].cpu_ms);
    }
}

std::optional<Estimate> Costs::sum(std::optional<double> PassCost::*figure, bool mask_only) const {
    std::vector<double> sums;
    for (const auto& [number, frame] : frames) {
        double total = 0;
        for (size_t p = 0; p < frame.passes.size(); ++p) {
            if (mask_only && !passes[p].mask) continue;
            if (!(frame.passes[p].*figure)) return std::nullopt;
            total += *(frame.passes[p].*figure);
        }
        sums.push_back(total);
    }
    return median_of(std::move(sums));
}

std::optional<Estimate> Costs::pass(size_t index, std::optional<double> PassCost::*figure) const {
    std::vector<double> samples;
    for (const auto& [number, frame] : frames)
        if (const auto& value = frame.passes[index].*figure) samples.push_back(*value);
    return median_of(std::move(samples));
}

Turns::Turns(const std::vector<std::unique_ptr<Runner>>& runners, const TurnsOptions& options,
             const std::function<void()>& step)
    : options_(options), costs_(runners.size()) {
    for (size_t contender = 0; contender < runners.size(); ++contender) originals_.push_back(contender);
    for (uint32_t round = 0; round < options.rounds(); ++round) {
        for (const auto& runner : runners) runner->set_seed(round + 1);
        for (uint32_t frame = 0; frame < options.frames; ++frame) {
            for (size_t turn = 0; turn < runners.size(); ++turn) {
                const size_t contender = (turn + frame + round) % runners.size();
                Runner& runner = *runners[contender];
                const bool original = originals_[contender] == contender;
                const bool shown = options.shows(contender, round, frame);
                if (!shown && !takes_turn(options, runner, original, round, frame)) continue;
                const bool judged = original && round < options.seeds && options.judged.contains(frame);
                keep(contender, runner.run(frame, frame == 0, judged || shown), runner, round, frame);
            }
            step();
        }
        if (round == 0) find_originals(runners);
    }
}

void Turns::keep(size_t contender, Sample sample, const Runner& runner, uint32_t round, uint32_t frame) {
    if (!sample.visibility.empty()) masks_[{contender, frame}].push_back(std::move(sample.visibility));
    if (round >= options_.timings || !options_.timed.contains(frame) || !sample.true_cost) return;
    costs_[contender].passes = runner.passes();
    costs_[contender].add(frame, std::move(sample));
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
