// SPDX-License-Identifier: MIT
// The host's graphics shaders, embedded by the build as arrays of words.
#pragma once

#include <span>

#include "host/device.h"

namespace penumbra {

Owned<VkShaderModule> make_shader_module(const Device& device, std::span<const uint32_t> code,
                                         const char* what);
// Entry point main.
VkPipelineShaderStageCreateInfo shader_stage(VkShaderStageFlagBits bit, VkShaderModule module);

}  // namespace penumbra
