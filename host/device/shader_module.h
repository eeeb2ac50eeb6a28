// SPDX-License-Identifier: MIT
// The host's shaders, compiled and embedded by the build, and compute pipelines of any.
#pragma once

#include <span>
#include <string_view>

#include "host/device/device.h"

namespace penumbra {

// SPIR-V of the shader of that name ("gbuffer.vert") in one of the rooms.
std::span<const uint32_t> host_shader(std::string_view name);

Owned<VkShaderModule> make_shader_module(const Device& device, std::span<const uint32_t> code,
                                         const char* what);
// Entry point main.
VkPipelineShaderStageCreateInfo shader_stage(VkShaderStageFlagBits bit, VkShaderModule module);

// Of one shader with the entry point main. `constants`: its specialisation's.
Owned<VkPipeline> make_compute_pipeline(const Device& device, std::span<const uint32_t> code,
                                        VkPipelineLayout layout, const char* what,
                                        const VkSpecializationInfo* constants = nullptr,
                                        VkPipelineCreateFlags flags = 0);

}  // namespace penumbra
