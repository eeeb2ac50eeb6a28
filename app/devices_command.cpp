// SPDX-License-Identifier: MIT
// penumbra devices: what there is to run on, and what keeps a device from being used.
#include <fmt/format.h>

#include "app/commands.h"
#include "host/device/device.h"

namespace penumbra {

int run_devices() {
    const std::vector<DeviceInfo> devices = list_devices();
    for (const DeviceInfo& d : devices)
        fmt::print("{}  [{}]  {}  Vulkan {}.{}  subgroup {}{}\n", d.name, d.driver, d.is_cpu ? "cpu" : "gpu",
                   VK_API_VERSION_MAJOR(d.api_version), VK_API_VERSION_MINOR(d.api_version), d.subgroup_size,
                   d.missing.empty() ? "" : "  cannot be used: " + d.missing);
    if (devices.empty()) fmt::print(stderr, "no Vulkan device; is a driver installed?\n");
    return devices.empty() ? exit_failed : exit_good;
}

}  // namespace penumbra
