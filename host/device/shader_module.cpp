// SPDX-License-Identifier: MIT
#include "host/device/shader_module.h"

#include <stdexcept>

#include "graph/embedded_file.h"

namespace penumbra {

std::span<const EmbeddedFile> host_shaders();

std::span<const uint32_t> host_shader(std::string_view name) {
    const EmbeddedFile* file = find_embedded(host_shaders(), name);
    if (!file) throw std::logic_error("the build has not embedded " + std::string(name));
    return {reinterpret_cast<const uint32_t*>(file->bytes.data()), file->bytes.size() / sizeof(uint32_t)};
}

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

Owned<VkPipeline> make_compute_pipeline(const Device& device, std::span<const uint32_t> code,
                                        VkPipelineLayout layout, const char* what,
                                        const VkSpecializationInfo* constants, VkPipelineCreateFlags flags) {
    const Owned<VkShaderModule> module = make_shader_module(device, code, what);
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.flags = flags;
    info.stage = shader_stage(VK_SHADER_STAGE_COMPUTE_BIT, module.get());
    info.stage.pSpecializationInfo = constants;
    info.layout = layout;
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateComputePipelines(device.get(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          "vkCreateComputePipelines", what);
    return {device.get(), pipeline};
}

}  // namespace penumbra
