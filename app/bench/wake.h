// SPDX-License-Identifier: MIT
// Work that keeps a GPU's clocks where a program that draws without pause has them. Between the frames that
// are timed the host moves models and rebuilds trees, which takes many times as long as the frame; a GPU
// slows down meanwhile, and what is timed then takes several times as long.
#pragma once

#include "host/device/gpu.h"

namespace penumbra::bench {

class Wake {
  public:
    explicit Wake(Device& device);

    // Some 20 ms of it.
    void record(VkCommandBuffer commands) const;

  private:
    void record_fills(VkCommandBuffer commands, uint32_t count) const;

    GpuBuffer buffer_;
    uint32_t fills_ = 1;
};

}  // namespace penumbra::bench
