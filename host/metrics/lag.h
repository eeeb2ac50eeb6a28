// SPDX-License-Identifier: MIT
// Lag: how far the image is behind a truth that moves. Behind a moving edge as a distance in pixels; after a
// sudden change as the number of frames until a tenth of it is left.
#pragma once

#include <optional>

#include "host/metrics/compared_frame.h"

namespace penumbra {

// Shift along the shadow edges' normals, sub-pixel, under which the truth fits the image best; positive: the
// image is behind where the edges were heading. Absent where no edge moves. `truth_before` is the previous
// frame's.
std::optional<double> lag_px(const ComparedFrame& now, std::span<const float> truth_before);

// The largest sudden change among consecutive truths: pixels that change by more than a half and then stay.
class StepFinder {
  public:
    // Frames in rising order; a gap starts anew.
    void add(uint32_t frame, std::span<const float> truth, std::span<const uint8_t> counted);

    struct Step {
        uint32_t frame = 0;  // the first with the new truth
        std::vector<uint32_t> pixels;
        double size = 0;  // sum of the changes
    };
    // Absent where fewer than 16 pixels change.
    std::optional<Step> step() const;

  private:
    uint32_t last_frame_ = 0;
    std::vector<float> last_;
    Step best_;
    std::vector<float> new_truth_, changes_;  // of best_.pixels
};

// What is left of the change, frame by frame: mean |image - truth| over the step's pixels by the mean change.
double step_remainder(const StepFinder::Step& step, const ComparedFrame& frame);

struct StepResponse {
    std::optional<double> k90;       // the first frame after which at most a tenth is ever left
    std::optional<double> residual;  // sum of the remainders, in frames
};
// `remainders` from the step's frame on, without gaps.
StepResponse step_response(std::span<const double> remainders);

}  // namespace penumbra
