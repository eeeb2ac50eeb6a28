// SPDX-License-Identifier: MIT
// What tests run pipelines on shots with: a shipped shot, a session, and a shipped pipeline's mask of a shot.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "app/session.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"

namespace penumbra::test {

Shot shot_named(const std::string& name);  // scenes/NAME.shot.json; throws with the diagnostics

// Throws with the diagnostics. A test that looks at those or at the warnings calls Session::open() itself.
std::unique_ptr<Session> open_session(const CheckedPipeline& pipeline, Shot shot,
                                      const SessionOptions& options, const NodeSet& nodes = shipped_nodes(),
                                      Device& device = gpu());

// The mask, frame by frame as the test wants them, and, unless it wants some, without jitter.
class ShotRun {
  public:
    // `settings`: as of `penumbra render --set`; `captures`: besides the visibility; `facts`: instead of what
    // the shot says. Throws with the diagnostics.
    ShotRun(Shot shot, const std::string& pipeline, std::vector<std::string> settings,
            std::vector<std::string> captures, const Facts& facts = {},
            std::array<uint32_t, 2> size = {192, 108});
    void frame(uint32_t index, bool reset);
    void set_jitter(bool wanted) { session_->set_jitter(wanted); }

    const View& view() const { return session_->view(); }
    std::vector<uint32_t> words(const char* name) const;  // of a buffer, in the last frame
    std::vector<float> visibility() const;                // row by row

  private:
    Shot shot_;
    std::unique_ptr<Session> session_;
};

}  // namespace penumbra::test
