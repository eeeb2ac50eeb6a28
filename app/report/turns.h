// SPDX-License-Identifier: MIT
// One run: every contender through the same frames under every seed, in turns. Keeps the masks of judged
// frames and the cost of every frame that is warm.
#pragma once

#include <functional>
#include <map>
#include <set>

#include "app/report/results.h"

namespace penumbra::report {

struct TurnsOptions {
    uint32_t frames = 1, seeds = 1, warm_up = 0;
    std::set<uint32_t> judged;
};

// Figures of one contender, by pass, over frames and seeds.
struct Costs {
    std::vector<PassName> passes;
    std::vector<std::vector<PassCost>> frames;
    std::vector<double> rays;  // per frame

    // Of the sum over some passes; nothing where a pass was not timed.
    std::optional<Estimate> sum(std::optional<double> PassCost::*figure, bool mask_only) const;
    std::optional<Estimate> pass(size_t index, std::optional<double> PassCost::*figure) const;
};

class Turns {
  public:
    using Masks = std::vector<std::vector<float>>;  // one per seed

    Turns(const std::vector<std::unique_ptr<Runner>>& runners, size_t contenders, const TurnsOptions& options,
          const std::function<void()>& step);

    const Masks& masks(size_t contender, uint32_t frame) const { return masks_.at({contender, frame}); }
    const Costs& costs(size_t contender) const { return costs_[contender]; }

  private:
    void keep(Sample sample, const Runner& runner, uint32_t frame, const TurnsOptions& options);

    std::map<std::pair<size_t, uint32_t>, Masks> masks_;
    std::vector<Costs> costs_;
};

}  // namespace penumbra::report
