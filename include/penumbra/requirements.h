// SPDX-License-Identifier: MIT
// What a plan needs of a device, as data: read from its shaders' SPIR-V, its bindings and its resources. A
// host asks before it makes its device; what is enabled, only the host can tell.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "penumbra/device.h"
#include "penumbra/export.h"

namespace penumbra PENUMBRA_API {

struct Requirement {
    enum class Kind : uint8_t {
        version,    // of Vulkan; value: VK_MAKE_API_VERSION
        extension,  // to enable
        feature,  // to enable, by the name of its member in Vulkan's structs; "SPIR-V capability N", which is
                  // never met: a shader of the host's declares what penumbra has no feature for
        subgroup,  // operations in compute shaders; value: VkSubgroupFeatureFlags
        limit,     // by the name of its member in VkPhysicalDeviceLimits; value: the least
        format     // of penumbra's names; value: VkFormatFeatureFlags
    };
    Kind kind = Kind::feature;
    std::string name;
    uint64_t value = 0;
    std::string why;  // what in the plan needs it: passes, resources
};
const char* kind_name(Requirement::Kind kind);

std::vector<Requirement> requirements(const Plan& plan);

// Turns a feature on in whichever of the host's structs has a member of that name: `chain` and, behind it,
// VkPhysicalDeviceVulkan11Features to 13Features. False: it is on in none, since the struct is not in the
// chain, or it is an extension's, or no feature.
bool enable(const Requirement& feature, VkPhysicalDeviceFeatures2& chain);

// Those that a physical device cannot meet; `handles` needs no device.
std::vector<Requirement> unmet(const Plan& plan, const DeviceHandles& handles);

}  // namespace penumbra
