// SPDX-License-Identifier: MIT
// One run: every contender through the same frames in every round, in turns. The first rounds are seeds:
// these keep the masks of judged frames. Costs are of timed frames, of each pass the least of all rounds:
// what else the machine does only adds. What no figure depends on is not run: a pipeline without history
// skips frames that are neither judged nor timed (but not those before, which its cost depends on), and
// contenders whose masks are the same to the bit in all judged frames under the first seed are taken to be
// the same under the others: of these only one is judged there, the one with the fewest passes. Each is timed
// as often as any.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "app/report/results.h"

namespace penumbra::report {

struct TurnsOptions {
    uint32_t frames = 1, seeds = 1;
    uint32_t timings = 0;  // of each pass in each of `timed`: so many rounds at least
    std::set<uint32_t> judged, timed;
    // The masks of these contenders in these frames are kept under the first seed, to be shown.
    std::vector<size_t> showing;
    std::set<uint32_t> shown;
    // Nothing moves: frames of a pipeline without history are alike but for their noise, and the last two are
    // enough of them.
    bool still = false;

    uint32_t rounds() const { return std::max(seeds, timings); }
    bool shows(size_t contender, uint32_t round, uint32_t frame) const {
        return round == 0 && shown.contains(frame) && std::ranges::count(showing, contender) > 0;
    }
};

// Whether a contender runs in a frame of a round, from 0; `original`: whether its masks are judged.
bool takes_turn(const TurnsOptions& options, const Runner& runner, bool original, uint32_t round,
                uint32_t frame);

struct FrameCosts {
    std::vector<PassCost> passes;
    double rays = 0;
    std::optional<double> maps_cpu_ms;  // where shadow maps are read
};

// Figures of one contender, by pass, over timed frames.
struct Costs {
    std::vector<PassName> passes;
    std::map<uint32_t, FrameCosts> frames;

    // Of a frame that was run once more: its least figures count.
    void add(uint32_t frame, Sample sample);
    // Of the sum over some passes; nothing where a pass was not timed.
    std::optional<Estimate> sum(std::optional<double> PassCost::*figure, bool mask_only) const;
    std::optional<Estimate> pass(size_t index, std::optional<double> PassCost::*figure) const;
};

class Turns {
  public:
    using Masks = std::vector<std::vector<float>>;  // one per seed

    // `step` is called after each frame of all.
    Turns(const std::vector<std::unique_ptr<Runner>>& runners, const TurnsOptions& options,
          const std::function<void()>& step);

    // Of a frame and a contender that are shown.
    const std::vector<float>& shown(size_t contender, uint32_t frame) const {
        return masks_.at({contender, frame}).front();
    }
    // Of a judged frame; or of the last one, where they are alike.
    const Masks& masks(size_t contender, uint32_t frame) const;
    // Per contender: the one that stands for it, mostly itself.
    const std::vector<size_t>& originals() const { return originals_; }
    const Costs& costs(size_t contender) const { return costs_[contender]; }

  private:
    void keep(size_t contender, Sample sample, const Runner& runner, uint32_t round, uint32_t frame);
    void find_originals(const std::vector<std::unique_ptr<Runner>>& runners);

    TurnsOptions options_;
    std::vector<size_t> originals_;
    std::map<std::pair<size_t, uint32_t>, Masks> masks_;
    std::vector<Costs> costs_;
};

}  // namespace penumbra::report
