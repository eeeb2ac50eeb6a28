// SPDX-License-Identifier: MIT
// One pipeline per compute pass, specialised with the plan's constants; set 0 holds internal resources, set 1
// the frame block, counters, host slots and tables.
#include "graph/program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace penumbra {
namespace {

VkDescriptorSetLayoutBinding layout_binding(uint32_t binding, VkDescriptorType type) {
    return {binding, type, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
}

Owned<VkDescriptorSetLayout> make_set_layout(VkDevice device,
                                             const std::vector<VkDescriptorSetLayoutBinding>& bindings,
                                             const std::string& what) {
    VkDescriptorSetLayoutCreateInfo create{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    create.bindingCount = static_cast<uint32_t>(bindings.size());
    create.pBindings = bindings.data();
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    check(vkCreateDescriptorSetLayout(device, &create, nullptr, &layout), "vkCreateDescriptorSetLayout",
          what);
    return {device, layout};
}

std::vector<uint32_t> spirv_of(const PlanPass& pass) {
    Diagnostics diagnostics;
    const std::vector<uint32_t>* found = find_shader(*pass.entry, pass.variant, diagnostics);
    if (!found)
        throw VulkanError(
            VK_ERROR_INITIALIZATION_FAILED,
            fmt::format("node {} has no shader for its variant\n{}", pass.node, diagnostics.text()));
    std::vector<uint32_t> spirv = *found;
    std::vector<uint32_t> host;
    for (const PlanBinding& binding : pass.bindings)
        if (binding.host) host.push_back(binding.binding);
    bind_to_sets(spirv, host);
    return spirv;
}

}  // namespace

bool writes_chain(const PlanBinding& binding) {
    return binding.port->output && binding.port->levels;
}

VkDescriptorType descriptor_type(const Plan& plan, const PlanPass& pass, const PlanBinding& binding) {
    const Port& port =
        binding.port->updates.empty() ? *binding.port : *pass.entry->type.port(binding.port->updates);
    // A scene port's slots have kinds of their own.
    switch (binding.host ? plan.slots[binding.index].kind : port.kind) {
        case PortKind::image:
            return port.storage ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE
                                : VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
        case PortKind::texels:
            return binding.port->output ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER
                                        : VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
        case PortKind::buffer:
            return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        case PortKind::block:
            return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
        case PortKind::scene:
            return VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
    }
    return VK_DESCRIPTOR_TYPE_MAX_ENUM;
}

Program::Program(const DeviceHandles& handles, std::shared_ptr<const Plan> plan)
    : handles_(handles), plan_(std::move(plan)), passes_(plan_->passes.size()) {
    for (int linear = 0; linear < 2; ++linear) {
        VkSamplerCreateInfo create{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
        create.magFilter = create.minFilter = linear ? VK_FILTER_LINEAR : VK_FILTER_NEAREST;
        create.addressModeU = create.addressModeV = create.addressModeW =
            VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
        VkSampler sampler = VK_NULL_HANDLE;
        check(vkCreateSampler(handles_.device, &create, nullptr, &sampler), "vkCreateSampler",
              "a port's sampler");
        samplers_[linear] = {handles_.device, sampler};
    }
    VkPipelineCacheCreateInfo create{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
    VkPipelineCache cache = VK_NULL_HANDLE;
    check(vkCreatePipelineCache(handles_.device, &create, nullptr, &cache), "vkCreatePipelineCache",
          plan_->pipeline);
    cache_ = {handles_.device, cache};
    make_tables();
    for (size_t i = 0; i < passes_.size(); ++i) {
        const PlanPass& pass = plan_->passes[i];
        if (pass.kind == PassKind::host && !pass.entry->callback)
            throw VulkanError(VK_ERROR_INITIALIZATION_FAILED,
                              fmt::format("host node {} has no callback", pass.node));
        if (pass.kind == PassKind::compute) make_pass(i);
    }
}

const TableImage& Program::table(const std::string& node_type, const std::string& name) const {
    return *std::find_if(tables_.begin(), tables_.end(),
                         [&](const TableImage& t) { return t.name == node_type + "/" + name; });
}

void Program::make_tables() {
    for (const PlanPass& pass : plan_->passes) {
        if (!pass.entry) continue;
        for (const Table& table : pass.entry->type.tables) {
            if (!exists(pass.variant, table.name)) continue;
            TableImage t;
            t.name = pass.entry->type.name + "/" + table.name;
            if (std::any_of(tables_.begin(), tables_.end(),
                            [&](const TableImage& o) { return o.name == t.name; }))
                continue;
            const auto data = std::find_if(pass.entry->tables.begin(), pass.entry->tables.end(),
                                           [&](const TableData& d) { return d.name == table.name; });
            const size_t bytes = size_t{table.extent[0]} * table.extent[1] * info(table.format).bytes;
            if (data == pass.entry->tables.end() || data->texels.size() != bytes)
                throw VulkanError(VK_ERROR_INITIALIZATION_FAILED,
                                  fmt::format("table {} does not hold {} bytes", t.name, bytes));
            t.extent = table.extent;
            VkImageCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
            create.imageType = VK_IMAGE_TYPE_2D;
            create.format = info(table.format).vk;
            create.extent = {t.extent[0], t.extent[1], 1};
            create.mipLevels = create.arrayLayers = 1;
            create.samples = VK_SAMPLE_COUNT_1_BIT;
            create.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
            VkImage image = VK_NULL_HANDLE;
            check(vkCreateImage(handles_.device, &create, nullptr, &image), "vkCreateImage", t.name);
            t.image = {handles_.device, image};
            VkMemoryRequirements need;
            vkGetImageMemoryRequirements(handles_.device, image, &need);
            const VkMemoryAllocateInfo allocate{
                VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, need.size,
                memory_type(handles_.physical, need.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT)};
            VkDeviceMemory memory = VK_NULL_HANDLE;
            check(vkAllocateMemory(handles_.device, &allocate, nullptr, &memory), "vkAllocateMemory", t.name);
            t.memory = {handles_.device, memory};
            check(vkBindImageMemory(handles_.device, image, memory, 0), "vkBindImageMemory", t.name);
            VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
            view.image = image;
            view.viewType = VK_IMAGE_VIEW_TYPE_2D;
            view.format = create.format;
            view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
            VkImageView handle = VK_NULL_HANDLE;
            check(vkCreateImageView(handles_.device, &view, nullptr, &handle), "vkCreateImageView", t.name);
            t.view = {handles_.device, handle};
            t.staging = MappedBuffer(handles_, bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, t.name);
            std::memcpy(t.staging.data(), data->texels.data(), bytes);
            tables_.push_back(std::move(t));
        }
    }
}

void Program::make_pass(size_t index) {
    const PlanPass& pass = plan_->passes[index];
    PassProgram& out = passes_[index];
    const NodeType& type = pass.entry->type;

    std::array<std::vector<VkDescriptorSetLayoutBinding>, 2> sets;
    sets[1].push_back(layout_binding(frame_binding, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER));
    sets[1].push_back(layout_binding(counters_binding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER));
    for (const PlanBinding& binding : pass.bindings) {
        sets[binding.host].push_back(layout_binding(binding.binding, descriptor_type(*plan_, pass, binding)));
        if (writes_chain(binding))
            sets[0].push_back(layout_binding(binding.binding + 1, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE));
    }
    for (uint32_t i = 0; i < type.tables.size(); ++i)
        if (exists(pass.variant, type.tables[i].name))
            sets[1].push_back(
                layout_binding(first_table_binding(type) + i, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER));
    std::array<VkDescriptorSetLayout, 2> layouts{};
    for (size_t s = 0; s < 2; ++s) {
        out.set_layouts[s] = make_set_layout(handles_.device, sets[s], pass.node);
        layouts[s] = out.set_layouts[s].get();
    }

    const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, static_cast<uint32_t>(pass.push.size())};
    VkPipelineLayoutCreateInfo layout_create{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout_create.setLayoutCount = 2;
    layout_create.pSetLayouts = layouts.data();
    layout_create.pushConstantRangeCount = pass.push.empty() ? 0 : 1;
    layout_create.pPushConstantRanges = &push;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    check(vkCreatePipelineLayout(handles_.device, &layout_create, nullptr, &layout), "vkCreatePipelineLayout",
          pass.node);
    out.layout = {handles_.device, layout};

    const std::vector<uint32_t> spirv = spirv_of(pass);
    VkShaderModuleCreateInfo module_create{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    module_create.codeSize = spirv.size() * sizeof(uint32_t);
    module_create.pCode = spirv.data();
    VkShaderModule module = VK_NULL_HANDLE;
    check(vkCreateShaderModule(handles_.device, &module_create, nullptr, &module), "vkCreateShaderModule",
          pass.node);
    const Owned<VkShaderModule> owned_module(handles_.device, module);

    std::vector<VkSpecializationMapEntry> entries;
    for (uint32_t id = 0; id < pass.constants.size(); ++id) entries.push_back({id, id * 4, 4});
    const VkSpecializationInfo specialisation{static_cast<uint32_t>(entries.size()), entries.data(),
                                              pass.constants.size() * 4, pass.constants.data()};
    VkComputePipelineCreateInfo create{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    create.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    create.stage.module = module;
    create.stage.pName = "main";
    create.stage.pSpecializationInfo = &specialisation;
    create.layout = layout;
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateComputePipelines(handles_.device, cache_.get(), 1, &create, nullptr, &pipeline),
          "vkCreateComputePipelines", pass.node);
    out.pipeline = {handles_.device, pipeline};
}

void Program::record_uploads(VkCommandBuffer cmd) const {
    if (uploaded_) return;
    uploaded_ = true;
    for (const TableImage& t : tables_) {
        VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
        barrier.image = t.image.get();
        barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        barrier.dstStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
        barrier.dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
        barrier.newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
        VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
        dependency.imageMemoryBarrierCount = 1;
        dependency.pImageMemoryBarriers = &barrier;
        vkCmdPipelineBarrier2(cmd, &dependency);
        VkBufferImageCopy copy{};
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.imageExtent = {t.extent[0], t.extent[1], 1};
        vkCmdCopyBufferToImage(cmd, t.staging.get(), t.image.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                               &copy);
        barrier.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
        barrier.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
        barrier.dstStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
        barrier.dstAccessMask = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
        barrier.oldLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
        barrier.newLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
        vkCmdPipelineBarrier2(cmd, &dependency);
    }
}

}  // namespace penumbra
