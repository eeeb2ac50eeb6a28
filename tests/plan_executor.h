// SPDX-License-Identifier: MIT
// A second executor of plans, to hold plan.json to its word: it knows the JSON, the files beside it and
// Vulkan, and nothing of penumbra's. No care is taken of speed: descriptors are written anew every frame,
// which is waited for.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/device/gpu.h"

namespace penumbra::test {

class PlanExecutor {
  public:
    explicit PlanExecutor(const std::filesystem::path& folder);
    ~PlanExecutor();

    // `slots`: bytes by slot, as tests/recording.h has them.
    void frame(const std::vector<std::byte>& frame_block,
               const std::map<std::string, std::vector<std::byte>>& slots);
    std::vector<std::string> slots() const;
    std::vector<std::byte> output(const std::string& name) const;  // of the last frame

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace penumbra::test
