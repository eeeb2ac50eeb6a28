// SPDX-License-Identifier: MIT
// A view of a plan that is made for a largest size, fed with recorded frames of any size up to that: their
// images lie in the top left corner of larger ones, beside garbage.
#pragma once

#include <memory>
#include <optional>

#include "host/device/gpu.h"
#include "penumbra/graph.h"
#include "tests/recording.h"

namespace penumbra::test {

// The frame's part of what was captured of an image for the plan's.
Bytes cropped(const Plan& plan, const std::string& name, std::span<const std::byte> bytes, Extent frame);

class SizedRun {
  public:
    // With the facts of a recording's plan, and jittered as it was.
    SizedRun(const CheckedPipeline& pipeline, Extent largest, const Plan& recorded);

    // `last`: the one before it, whose jitter it is to know.
    void frame(const RecordedFrame& frame, const RecordedFrame* last);
    Bytes output(const std::string& name) const;  // of the last frame, its part
    const View& view() const { return *view_; }

  private:
    struct Input {
        GpuImage image;
        GpuBuffer buffer;
        GpuTexels texels;
    };
    Input bring(const HostSlot& slot, const Bytes& bytes, Extent size) const;

    std::unique_ptr<View> view_;
    Extent size_;
};

}  // namespace penumbra::test
