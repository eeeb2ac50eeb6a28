// SPDX-License-Identifier: MIT
#include "app/bench/wake.h"

#include <algorithm>
#include <chrono>

namespace penumbra::bench {
namespace {

constexpr VkDeviceSize bytes = 64 << 20;
constexpr double wanted_ms = 20;
constexpr uint32_t tried = 64;

}  // namespace

Wake::Wake(Device& device)
    : buffer_(
          make_device_buffer(device, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, "what a GPU is woken with")) {
    using Clock = std::chrono::steady_clock;
    double ms = 0;
    for (int i = 0; i < 2; ++i) {  // the first with clocks as they are
        const auto start = Clock::now();
        device.run([&](VkCommandBuffer commands) { record_fills(commands, tried); });
        ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    }
    fills_ = static_cast<uint32_t>(std::clamp(wanted_ms / ms * tried, 1.0, 4096.0));
}

void Wake::record(VkCommandBuffer commands) const {
    record_fills(commands, fills_);
}

void Wake::record_fills(VkCommandBuffer commands, uint32_t count) const {
    VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
    barrier.srcStageMask = barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
    barrier.srcAccessMask = barrier.dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
    VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    dependency.memoryBarrierCount = 1;
    dependency.pMemoryBarriers = &barrier;
    for (uint32_t i = 0; i < count; ++i) {
        vkCmdPipelineBarrier2(commands, &dependency);
        vkCmdFillBuffer(commands, buffer_.get(), 0, VK_WHOLE_SIZE, i);
    }
}

}  // namespace penumbra::bench
