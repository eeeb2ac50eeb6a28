// SPDX-License-Identifier: MIT
// Radiance from beyond the scene, by direction: the input `environment`. A latitude-longitude map, rgba32f:
// texel centres at longitude (x + .5) / width * 2 pi from +x towards +z, and at (y + .5) / height * pi from
// straight up. From an EXR file, or made of the shot's sky.
#pragma once

#include <optional>
#include <vector>

#include "host/device/gpu.h"
#include "host/shots/shot.h"
#include "penumbra/diagnostic.h"

namespace penumbra {

struct EnvironmentMap {
    uint32_t width = 0, height = 0;
    std::vector<float> rgba;  // rows from the top; alpha is not read
};

// The shot's: its file, times its scale; or a sky, which depends on the height of a direction alone. Errors
// name the file: channels R, G and B are needed, finite and from 0 on.
std::optional<EnvironmentMap> make_environment(const Shot& shot, Diagnostics& diagnostics);

bool is_black(const EnvironmentMap& map);

// Sampled in SHADER_READ_ONLY_OPTIMAL.
GpuImage upload_environment(Device& device, const EnvironmentMap& map);

}  // namespace penumbra
