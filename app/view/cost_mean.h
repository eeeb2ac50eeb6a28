// SPDX-License-Identifier: MIT
// What the last frames of a plan cost: smooth enough to be read, quick enough to follow a change. A software
// device compiles shaders in the first frame that runs them, which takes seconds: that frame counts until
// there is another.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace penumbra::viewer {

struct PassCost {
    std::string node, type;
    std::optional<double> ms,
        cpu_ms;  // of the device's timestamps, of the process; mean over the last frames
};

class CostMean {
  public:
    void add(std::vector<PassCost> passes, double cpu_ms);  // of one frame
    const std::vector<PassCost>& passes() const { return passes_; }
    double cpu_ms() const { return cpu_ms_; }  // of all passes

  private:
    std::vector<PassCost> passes_;
    double cpu_ms_ = 0;
    uint32_t frames_ = 0;
};

}  // namespace penumbra::viewer
