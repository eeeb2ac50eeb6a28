// SPDX-License-Identifier: MIT
#include "host/shader_module.h"

namespace penumbra {

Owned<VkShaderModule> make_shader_module(const Device& device, std::span<const uint32_t> code,
                                         const char* what) {
    VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    info.codeSize = code.size_bytes();
    info.pCode = code.data();
    VkShaderModule module = VK_NULL_HANDLE;
    check(vkCreateShaderModule(device.get(), &info, nullptr, &module), "vkCreateShaderModule", what);
    return {device.get(), module};
}

VkPipelineShaderStageCreateInfo shader_stage(VkShaderStageFlagBits bit, VkShaderModule module) {
    VkPipelineShaderStageCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    info.stage = bit;
    info.module = module;
    info.pName = "main";
    return info;
}

}  // namespace penumbra
