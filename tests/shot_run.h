// SPDX-License-Identifier: MIT
// A shipped pipeline's mask of a shot, frame by frame as the test wants them, and, unless it wants some,
// without jitter.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "app/session.h"

namespace penumbra::test {

Shot shot_named(const std::string& name);  // scenes/NAME.shot.json; throws with the diagnostics

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
