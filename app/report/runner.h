// SPDX-License-Identifier: MIT
// A contender running on a shot: one session, asked for the mask and the cost of the frames that are needed.
#pragma once

#include <memory>
#include <vector>

#include "app/report/contenders.h"
#include "app/session.h"

namespace penumbra::report {

struct PassCost {
    std::optional<double> ms;      // GPU timestamps
    std::optional<double> cpu_ms;  // process CPU time; CPU devices only
};

// One frame.
struct Sample {
    std::vector<float> visibility;      // rows from the top; empty where it was not asked for
    std::vector<PassCost> passes;       // parallel to Runner::passes()
    std::optional<double> maps_cpu_ms;  // of drawing shadow maps, where it reads any
    uint64_t rays = 0;
    // Whether the costs are those of a run frame by frame (CostMemory).
    bool true_cost = true;
};

// A pass as the report lists it. `mask`: visibility depends on it.
struct PassName {
    std::string node, type;
    bool mask = false;
};

// Which frames before it a frame's cost depends on, though its mask does not. Shadow maps, and what is kept
// of them, cost by what has moved since the frame that was run before; a memo that each frame reads and
// writes (which proofs paid) by all of them.
enum class CostMemory : uint8_t { none, frame_before, all };

class Runner {
  public:
    // `costs`: whether they are wanted, pass by pass. On a CPU device each pass is then submitted by itself.
    static std::unique_ptr<Runner> open(Device& device, const NodeSet& nodes, const Contender& contender,
                                        const Shot& shot, std::array<uint32_t, 2> size, bool costs,
                                        KeptScene& scene, Diagnostics& diagnostics,
                                        std::vector<std::string>& warnings);

    void set_seed(uint32_t seed);
    Sample run(uint32_t frame, bool reset, bool judged);

    // Whether a frame's mask depends on frames before it.
    bool has_history() const { return has_history_; }
    CostMemory cost_memory() const { return cost_memory_; }
    const std::vector<PassName>& passes() const { return passes_; }

  private:
    Runner() = default;

    std::unique_ptr<Session> session_;
    bool has_history_ = false;
    CostMemory cost_memory_ = CostMemory::none;
    std::optional<uint32_t> last_;  // the frame that was run before
    bool unbroken_ = false;         // all frames since a reset were run
    std::vector<PassName> passes_;
    std::vector<size_t> plan_pass_;  // of the plan, per entry of passes_: captures are left out
};

// One per contender, in their order. Empty where any cannot be opened.
std::vector<std::unique_ptr<Runner>> open_runners(Device& device, const NodeSet& nodes,
                                                  const std::vector<Contender>& list, const Shot& shot,
                                                  std::array<uint32_t, 2> size, bool costs,
                                                  Diagnostics& diagnostics,
                                                  std::vector<std::string>& warnings);

}  // namespace penumbra::report
