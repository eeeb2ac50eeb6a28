// SPDX-License-Identifier: MIT
// What a plan needs of VkPhysicalDeviceLimits and of what newer structs added, and what a device has of them,
// by the names of their members.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "graph/functions.h"
#include "penumbra/plan.h"

namespace penumbra {

struct NeededLimit {
    std::string name;
    uint64_t value = 0;  // the most that anything needs
    std::string why;     // that which needs it: a pass, a resource
    bool pass = false;
};

std::vector<NeededLimit> needed_limits(const Plan& plan);

// Of a device of Vulkan 1.1 or later.
std::map<std::string, uint64_t> limits_of(VkPhysicalDevice device, const VulkanFunctions& vk);

}  // namespace penumbra
