// SPDX-License-Identifier: MIT
// What tests run pipelines on shots with: a shipped shot, a session, a pipeline's mask of a shot, and how
// good that is.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/session.h"
#include "app/truth.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"

namespace penumbra::test {

// scenes/NAME.shot.json, of another size where one is given; throws with the diagnostics.
Shot shot_named(const std::string& name, std::optional<std::array<uint32_t, 2>> size = {});

// Throws with the diagnostics. A test that looks at those or at the warnings calls Session::open() itself.
std::unique_ptr<Session> open_session(const CheckedPipeline& pipeline, Shot shot,
                                      const SessionOptions& options, const NodeSet& nodes = shipped_nodes(),
                                      Device& device = gpu());

struct RunOptions {
    std::vector<std::string> settings, captures;  // as of `penumbra render --set`; besides the visibility
    Facts facts;                                  // instead of what the shot says
    bool jitter = false;                          // where a node of the pipeline asks for it
    std::optional<uint32_t> seed;                 // instead of the shot's
    uint32_t cascade_size = 1024;                 // texels along a side of the sun's shadow maps
    bool alias = true;
    std::optional<uint32_t> poison;
};

// A pipeline's mask of a shot, frame by frame as the test wants them.
class ShotRun {
  public:
    // `pipeline`: as of shipped_pipeline(); tests' node types are known, too. Throws with the diagnostics.
    ShotRun(const std::string& pipeline, Shot shot, const RunOptions& options = {}, Device& device = gpu());

    std::vector<float> frame(uint32_t index, bool reset);  // visibility, row by row
    std::vector<float> up_to(uint32_t last);               // the same, of frame `last`
    std::vector<float> plane(const std::string& capture, size_t channel = 0) const;
    std::vector<uint32_t> words(const std::string& capture) const;  // of a buffer, in the last frame
    std::vector<float> mean(uint32_t frames);  // of the visibility over frames 0 .. frames - 1
    Session& session() const { return *session_; }

  private:
    std::unique_ptr<Session> session_;
};

// The converged visibility of a frozen frame.
Truth truth_of(const Shot& shot, uint32_t frame, uint32_t rays);

double rms(const std::vector<float>& a, const std::vector<float>& b);
size_t count_if(const std::vector<float>& values, const std::function<bool(float)>& test);
size_t nonfinite(const std::vector<float>& values);

// Sum of v (1 - v) over the penumbra by the squared errors of all pixels that `counted` accepts (all: none
// given).
double n_eff(const std::vector<float>& image, const std::vector<float>& truth,
             const std::function<bool(size_t)>& counted = {});
double n_eff_of_receivers(const std::vector<float>& image, const Truth& truth);

}  // namespace penumbra::test
