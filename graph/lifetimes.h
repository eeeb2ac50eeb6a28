// SPDX-License-Identifier: MIT
// When each resource is live and where it lies. A frame of P passes and the next one make a circle of 2P,
// since a history resource of frame f lives from its write in f to its last reader in f + 1 and the
// placements repeat every second frame. History is packed among the transients; nothing lives outside the
// heaps.
#pragma once

#include <functional>

#include "penumbra/plan.h"

namespace penumbra {

// Fills the length of every resource, whose first_pass is known, from the passes' uses.
void place_lifetimes(Plan& plan);

// Of the buffer that has an image's memory.
inline constexpr VkBufferUsageFlags rows_usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;

// What a resource asks a device for.
MemoryNeed need_of(const DeviceTable& device, const PlanResource& r);

// Fills bytes, alignment, heap and offsets, and the plan's memory report. `share_transients`: what lives
// within a frame lies in heaps of its own.
void place_memory(Plan& plan, const DeviceTable& device, bool share_transients, uint64_t optimum_search_nodes,
                  const std::function<void(double share)>& optimum_progress = {});

}  // namespace penumbra
