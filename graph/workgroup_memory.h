// SPDX-License-Identifier: MIT
// What a shader declares as `shared`, in bytes.
#pragma once

#include <cstdint>
#include <span>

namespace penumbra {

// As std430 lays the variables out one after the other, which is the most that Vulkan lets a device take for
// them. `constants`: what the specialisation constants 0 .. n-1 are set to. 0 for what is no SPIR-V.
uint64_t workgroup_bytes(std::span<const uint32_t> spirv, std::span<const uint32_t> constants);

}  // namespace penumbra
