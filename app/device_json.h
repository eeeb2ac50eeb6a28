// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>

#include "host/device/device.h"

namespace penumbra {

// What every document says of the device that it was measured on.
inline nlohmann::ordered_json device_json(const DeviceInfo& device) {
    return {{"name", device.name}, {"driver", device.driver}, {"class", device.is_cpu ? "cpu" : "gpu"}};
}

}  // namespace penumbra
