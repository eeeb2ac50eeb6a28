// SPDX-License-Identifier: MIT
// One pipeline per compute pass, specialised with the plan's constants; set 0 holds internal resources, set 1
// the frame block, counters, host slots and tables.
#include "penumbra/program.h"

#include <fmt/format.h>

#include <cstring>

namespace penumbra {
namespace {

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

constexpr VkDeviceSize absent_bytes = 16384;  // what every device lets a uniform buffer have

VkImageAspectFlags aspect(Format format) {
    return info(format).kind == FormatClass::depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

}  // namespace

Program::Program(const DeviceHandles& handles, std::shared_ptr<const Plan> plan)
    : handles_(handles), plan_(std::move(plan)), passes_(plan_->passes.size()) {
    for (int linear = 0; linear < 2; ++linear) {
        VkSamplerCreateInfo create{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
        create.magFilter = create.minFilter = linear ? VK_FILTER_LINEAR : VK_FILTER_NEAREST;
        create.addressModeU = create.addressModeV = create.addressModeW =
            VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
        create.maxLod = VK_LOD_CLAMP_NONE;
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
    make_absent();
    for (size_t i = 0; i < passes_.size(); ++i) {
        const PlanPass& pass = plan_->passes[i];
        if (pass.kind == PassKind::host && !pass.callback)
            throw VulkanError(VK_ERROR_INITIALIZATION_FAILED,
                              fmt::format("host node {} has no callback", pass.node));
        if (pass.kind == PassKind::compute) make_pass(i);
    }
}

StaticImage Program::make_image(Format format, std::array<uint32_t, 2> extent, VkImageUsageFlags usage,
                                bool layered, const std::string& what) const {
    StaticImage out;
    VkImageCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    create.imageType = VK_IMAGE_TYPE_2D;
    create.format = info(format).vk;
    create.extent = {extent[0], extent[1], 1};
    create.mipLevels = create.arrayLayers = 1;
    create.samples = VK_SAMPLE_COUNT_1_BIT;
    create.usage = usage;
    VkImage image = VK_NULL_HANDLE;
    check(vkCreateImage(handles_.device, &create, nullptr, &image), "vkCreateImage", what);
    out.image = {handles_.device, image};
    VkMemoryRequirements need;
    vkGetImageMemoryRequirements(handles_.device, image, &need);
    const VkMemoryAllocateInfo allocate{
        VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, need.size,
        memory_type(handles_.physical, need.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT)};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    check(vkAllocateMemory(handles_.device, &allocate, nullptr, &memory), "vkAllocateMemory", what);
    out.memory = {handles_.device, memory};
    check(vkBindImageMemory(handles_.device, image, memory, 0), "vkBindImageMemory", what);
    VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view.image = image;
    view.viewType = layered ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    view.format = create.format;
    view.subresourceRange = {aspect(format), 0, 1, 0, 1};
    VkImageView handle = VK_NULL_HANDLE;
    check(vkCreateImageView(handles_.device, &view, nullptr, &handle), "vkCreateImageView", what);
    out.view = {handles_.device, handle};
    return out;
}

void Program::make_tables() {
    for (const PlanTable& table : plan_->tables) {
        TableImage& t = tables_.emplace_back();
        t.image = make_image(table.format, table.extent,
                             VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, false, table.name);
        t.staging =
            MappedBuffer(handles_, table.texels->size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, table.name);
        std::memcpy(t.staging.data(), table.texels->data(), table.texels->size());
    }
}

void Program::make_absent() {
    const std::string what = "what is bound to absent inputs";
    for (const PlanPass& pass : plan_->passes)
        for (const PlanBinding& b : pass.bindings) {
            if (b.source != BindingSource::nothing) continue;
            const bool storage = b.type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
            if (storage || b.type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER) {
                StaticImage& image = absent_images_[{b.format, storage, b.layered}];
                if (!image.image)
                    image = make_image(b.format, {1, 1},
                                       storage ? VK_IMAGE_USAGE_STORAGE_BIT : VK_IMAGE_USAGE_SAMPLED_BIT,
                                       b.layered, what);
                continue;
            }
            if (!absent_buffer_.get())
                absent_buffer_ =
                    MappedBuffer(handles_, absent_bytes,
                                 VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                     VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT,
                                 what);
            if (b.type != VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER || absent_texels_.contains(b.format))
                continue;
            VkBufferViewCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
            create.buffer = absent_buffer_.get();
            create.format = info(b.format).vk;
            create.range = VK_WHOLE_SIZE;
            VkBufferView view = VK_NULL_HANDLE;
            check(vkCreateBufferView(handles_.device, &create, nullptr, &view), "vkCreateBufferView", what);
            absent_texels_[b.format] = {handles_.device, view};
        }
}

VkImageView Program::absent_image(const PlanBinding& binding) const {
    return absent_images_
        .at({binding.format, binding.type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, binding.layered})
        .view.get();
}

void Program::make_pass(size_t index) {
    const PlanPass& pass = plan_->passes[index];
    PassProgram& out = passes_[index];

    std::array<std::vector<VkDescriptorSetLayoutBinding>, 2> sets;
    for (const PlanBinding& b : pass.bindings)
        sets[b.set].push_back({b.binding, b.type, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
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

    if (!pass.module)
        throw VulkanError(VK_ERROR_INITIALIZATION_FAILED,
                          fmt::format("the plan was made without a shader for node {}", pass.node));
    const std::vector<uint32_t>& spirv = plan_->modules[*pass.module];
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
    struct Stand {  // of an image, before or after
        VkImageLayout layout;
        VkPipelineStageFlags2 stages;
        VkAccessFlags2 access;
    };
    constexpr Stand fresh{VK_IMAGE_LAYOUT_UNDEFINED, VK_PIPELINE_STAGE_2_NONE, VK_ACCESS_2_NONE},
        filled{VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_2_COPY_BIT,
               VK_ACCESS_2_TRANSFER_WRITE_BIT},
        table{VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
              VK_ACCESS_2_SHADER_SAMPLED_READ_BIT},
        absent{VK_IMAGE_LAYOUT_GENERAL, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
               VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT};
    const auto bring = [&](VkImage image, Format format, const Stand& from, const Stand& to) {
        VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
        barrier.srcStageMask = from.stages;
        barrier.srcAccessMask = from.access;
        barrier.dstStageMask = to.stages;
        barrier.dstAccessMask = to.access;
        barrier.oldLayout = from.layout;
        barrier.newLayout = to.layout;
        barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
        barrier.image = image;
        barrier.subresourceRange = {aspect(format), 0, 1, 0, 1};
        VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
        dependency.imageMemoryBarrierCount = 1;
        dependency.pImageMemoryBarriers = &barrier;
        vkCmdPipelineBarrier2(cmd, &dependency);
    };
    for (size_t i = 0; i < tables_.size(); ++i) {
        const PlanTable& plan = plan_->tables[i];
        const VkImage image = tables_[i].image.image.get();
        bring(image, plan.format, fresh, filled);
        VkBufferImageCopy copy{};
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.imageExtent = {plan.extent[0], plan.extent[1], 1};
        vkCmdCopyBufferToImage(cmd, tables_[i].staging.get(), image, filled.layout, 1, &copy);
        bring(image, plan.format, filled, table);
    }
    for (const auto& [key, stand_in] : absent_images_) bring(stand_in.image.get(), key.format, fresh, absent);
}

}  // namespace penumbra
