// SPDX-License-Identifier: MIT
// One run: every contender through the same frames under every seed, in turns. Keeps the masks of judged
// frames and the cost of every frame that is warm. What no figure depends on is not run: a pipeline without
// history skips frames that are not judged (but under the first seed it runs those before that its cost
// depends on), and contenders whose masks are the same to the bit in all judged frames under the first seed
// are taken to be the same under the others: of these only one goes on, the one with the fewest passes.
#pragma once

#include <functional>
#include <map>
#include <set>

#include "app/report/results.h"

namespace penumbra::report {

struct TurnsOptions {
    uint32_t frames = 1, seeds = 1, warm_up = 0;
    std::set<uint32_t> judged;
    bool costs = false;  // of interest
    // Nothing moves: frames of a pipeline without history are alike but for their noise, and the last two are
    // enough of them.
    bool still = false;
};

// Figures of one contender, by pass, over frames and seeds.
struct Costs {
    std::vector<PassName> passes;
    std::vector<std::vector<PassCost>> frames;
    std::vector<double> rays;         // per frame
    std::vector<double> maps_cpu_ms;  // per frame in which shadow maps are read

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

    // Of a judged frame; or of the last one, where they are alike.
    const Masks& masks(size_t contender, uint32_t frame) const;
    // Per contender: the one that stands for it, mostly itself.
    const std::vector<size_t>& originals() const { return originals_; }
    const Costs& costs(size_t contender) const { return costs_[contender]; }

  private:
    void keep(size_t contender, Sample sample, const Runner& runner, uint32_t frame);
    void find_originals(const std::vector<std::unique_ptr<Runner>>& runners);

    TurnsOptions options_;
    std::vector<size_t> originals_;
    std::map<std::pair<size_t, uint32_t>, Masks> masks_;
    std::vector<Costs> costs_;
};

}  // namespace penumbra::report
