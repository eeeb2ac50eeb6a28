// SPDX-License-Identifier: MIT
// What a driver's compiler made of a plan's shaders, in the driver's own words
// (VK_KHR_pipeline_executable_properties): registers, spills, scratch and shared memory, occupancy,
// instructions. Pipelines are made and nothing runs, so a driver without hardware behind it answers as well.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "host/device/device.h"
#include "penumbra/plan.h"

namespace penumbra {

struct Statistic {
    std::string name, description;  // the driver's
    std::variant<bool, int64_t, uint64_t, double> value;
};

// What a shader became: one, or of several widths where the driver chooses at the dispatch.
struct ExecutableStatics {
    std::string name;  // the driver's
    uint32_t subgroup_size = 0;
    std::vector<Statistic> statistics;  // in the driver's order
};

struct PassStatics {
    std::string node, type;
    std::array<uint32_t, 3> group{1, 1, 1};  // lanes
    std::vector<ExecutableStatics> executables;
};

// Of every compute pass, in the plan's order. The device was made with DeviceOptions::statistics. `progress`
// is called with the share of passes that is done. Throws VulkanError.
std::vector<PassStatics> pass_statics(const Device& device, const Plan& plan,
                                      const std::function<void(double share)>& progress = {});

}  // namespace penumbra
