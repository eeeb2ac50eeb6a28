// SPDX-License-Identifier: MIT
// Contenders running on one shot. A runner executes one pipeline and yields the mask of each contender that
// it stands for: one, or all of brute force, since N rays are the first N of more rays.
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

// One contender's frame.
struct Sample {
    size_t contender = 0;
    std::vector<float> visibility;  // rows from the top
    std::vector<PassCost> passes;   // parallel to Runner::passes()
    uint64_t rays = 0;
};

// A pass as the report lists it. `mask`: visibility depends on it.
struct PassName {
    std::string node, type;
    bool mask = false;
};

class Runner {
  public:
    // `contenders` are indices into `list`, which share one pipeline.
    static std::unique_ptr<Runner> open(Device& device, const NodeSet& nodes,
                                        const std::vector<Contender>& list, std::vector<size_t> contenders,
                                        const Shot& shot, std::array<uint32_t, 2> size,
                                        Diagnostics& diagnostics, std::vector<std::string>& warnings);

    void set_seed(uint32_t seed);
    // Executes the frame. Brute force has no past and does nothing where the frame is not `judged`.
    std::vector<Sample> run(uint32_t frame, bool reset, bool judged);

    const std::vector<PassName>& passes() const { return passes_; }
    const std::vector<size_t>& contenders() const { return contenders_; }
    const Session& session() const { return *session_; }

  private:
    Runner() = default;
    Sample sample(size_t contender, const FrameCost& cost) const;

    std::unique_ptr<Session> session_;
    std::vector<size_t> contenders_;
    std::vector<uint32_t> rays_;  // per contender; empty: an ordinary pipeline
    std::vector<PassName> passes_;
    std::vector<size_t> plan_pass_;  // of the plan, per entry of passes_: captures are left out
};

// One runner per pipeline that competes, in the order of the contenders. Empty where any cannot be opened.
std::vector<std::unique_ptr<Runner>> open_runners(Device& device, const NodeSet& nodes,
                                                  const std::vector<Contender>& list, const Shot& shot,
                                                  std::array<uint32_t, 2> size, Diagnostics& diagnostics,
                                                  std::vector<std::string>& warnings);

}  // namespace penumbra::report
