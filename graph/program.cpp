// SPDX-License-Identifier: MIT
// Pipelines of compute passes, specialised with the plan's constants; set 0 holds internal resources and
// tables, set 1 the frame block, counters and host slots.
#include <algorithm>
#include <cstring>

#include "graph/program_state.h"

namespace penumbra {
namespace {

Held<VkDescriptorSetLayout> make_set_layout(const GraphDevice& device,
                                            const std::vector<VkDescriptorSetLayoutBinding>& bindings,
                                            const std::string& what) {
    VkDescriptorSetLayoutCreateInfo create{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    create.bindingCount = static_cast<uint32_t>(bindings.size());
    create.pBindings = bindings.data();
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    require(device.vk().vkCreateDescriptorSetLayout(device.get(), &create, nullptr, &layout),
            "vkCreateDescriptorSetLayout", what);
    return {device, layout};
}

// Set layouts that are defined alike are compatible, so that one pipeline serves both.
bool are_one_program(const PlanPass& a, const PlanPass& b) {
    return a.kind == b.kind && a.module == b.module && a.constants == b.constants &&
           a.push.size() == b.push.size() &&
           std::ranges::equal(a.bindings, b.bindings, [](const PlanBinding& x, const PlanBinding& y) {
               return x.set == y.set && x.binding == y.binding && x.type == y.type;
           });
}

constexpr VkDeviceSize absent_bytes = 16384;  // what every device lets a uniform buffer have

}  // namespace

ProgramState::ProgramState(const DeviceHandles& handles, std::shared_ptr<const Plan> plan,
                           const ProgramOptions& options)
    : device_(std::make_shared<const GraphDevice>(handles)),
      plan_(std::move(plan)),
      program_of_(plan_->passes.size()) {
    check_device(*plan_, handles);
    for (int linear = 0; linear < 2; ++linear) {
        VkSamplerCreateInfo create{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
        create.magFilter = create.minFilter = linear ? VK_FILTER_LINEAR : VK_FILTER_NEAREST;
        create.addressModeU = create.addressModeV = create.addressModeW =
            VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
        create.maxLod = VK_LOD_CLAMP_NONE;
        VkSampler sampler = VK_NULL_HANDLE;
        require(device_->vk().vkCreateSampler(device_->get(), &create, nullptr, &sampler), "vkCreateSampler",
                "a port's sampler");
        samplers_[linear] = {*device_, sampler};
    }
    VkPipelineCacheCreateInfo create{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
    create.initialDataSize = options.pipeline_cache.size();
    create.pInitialData = options.pipeline_cache.data();
    VkPipelineCache cache = VK_NULL_HANDLE;
    require(device_->vk().vkCreatePipelineCache(device_->get(), &create, nullptr, &cache),
            "vkCreatePipelineCache", plan_->pipeline);
    cache_ = {*device_, cache};
    make_tables();
    make_absent();
    std::vector<const PlanPass*> first;  // of each program
    for (size_t i = 0; i < program_of_.size(); ++i) {
        const PlanPass& pass = plan_->passes[i];
        if (pass.kind == PassKind::host && !pass.callback)
            fail(ErrorCode::usage, pass.node, "this host node has no callback");
        if (pass.kind != PassKind::compute) continue;
        const auto same =
            std::ranges::find_if(first, [&](const PlanPass* p) { return are_one_program(*p, pass); });
        program_of_[i] = static_cast<size_t>(same - first.begin());
        if (same != first.end()) continue;
        first.push_back(&pass);
        programs_.push_back(make_program(pass));
    }
}

StaticImage ProgramState::make_image(Format format, std::array<uint32_t, 2> extent, VkImageUsageFlags usage,
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
    require(device_->vk().vkCreateImage(device_->get(), &create, nullptr, &image), "vkCreateImage", what);
    out.image = {*device_, image};
    device_->name(VK_OBJECT_TYPE_IMAGE, image, what);
    MemoryRequest request{.properties = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, .what = what.c_str()};
    device_->vk().vkGetImageMemoryRequirements(device_->get(), image, &request.need);
    out.memory = HeldMemory(*device_, request);
    const MemoryBlock& block = out.memory.block();
    require(device_->vk().vkBindImageMemory(device_->get(), image, block.memory, block.offset),
            "vkBindImageMemory", what);
    VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view.image = image;
    view.viewType = layered ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    view.format = create.format;
    view.subresourceRange = {aspects_of(format), 0, 1, 0, 1};
    VkImageView handle = VK_NULL_HANDLE;
    require(device_->vk().vkCreateImageView(device_->get(), &view, nullptr, &handle), "vkCreateImageView",
            what);
    out.view = {*device_, handle};
    return out;
}

void ProgramState::make_tables() {
    for (const PlanTable& table : plan_->tables) {
        TableImage& t = tables_.emplace_back();
        const VkImageUsageFlags usage =
            table.storage ? VK_IMAGE_USAGE_STORAGE_BIT : VK_IMAGE_USAGE_SAMPLED_BIT;
        t.image = make_image(table.format, table.extent, usage | VK_IMAGE_USAGE_TRANSFER_DST_BIT, false,
                             table.name);
        t.staging =
            MappedBuffer(*device_, table.texels->size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, table.name);
        std::memcpy(t.staging.data(), table.texels->data(), table.texels->size());
    }
}

void ProgramState::make_absent() {
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
                absent_buffer_ = MappedBuffer(
                    *device_, absent_bytes,
                    VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                        VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT,
                    what);
            if (!b.is_texels() || absent_texels_.contains(b.format)) continue;
            VkBufferViewCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
            create.buffer = absent_buffer_.get();
            create.format = info(b.format).vk;
            create.range = VK_WHOLE_SIZE;
            VkBufferView view = VK_NULL_HANDLE;
            require(device_->vk().vkCreateBufferView(device_->get(), &create, nullptr, &view),
                    "vkCreateBufferView", what);
            absent_texels_[b.format] = {*device_, view};
        }
}

VkImageView ProgramState::absent_image(const PlanBinding& binding) const {
    return absent_images_
        .at({binding.format, binding.type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, binding.layered})
        .view.get();
}

PassProgram ProgramState::make_program(const PlanPass& pass) const {
    PassProgram out;
    std::array<std::vector<VkDescriptorSetLayoutBinding>, 2> sets;
    for (const PlanBinding& b : pass.bindings)
        sets[b.set].push_back({b.binding, b.type, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    std::array<VkDescriptorSetLayout, 2> layouts{};
    for (size_t s = 0; s < 2; ++s) {
        out.set_layouts[s] = make_set_layout(*device_, sets[s], pass.node);
        layouts[s] = out.set_layouts[s].get();
    }

    const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, static_cast<uint32_t>(pass.push.size())};
    VkPipelineLayoutCreateInfo layout_create{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout_create.setLayoutCount = 2;
    layout_create.pSetLayouts = layouts.data();
    layout_create.pushConstantRangeCount = pass.push.empty() ? 0 : 1;
    layout_create.pPushConstantRanges = &push;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    require(device_->vk().vkCreatePipelineLayout(device_->get(), &layout_create, nullptr, &layout),
            "vkCreatePipelineLayout", pass.node);
    out.layout = {*device_, layout};

    if (!pass.module) fail(ErrorCode::usage, pass.node, "the plan was made without a shader for this node");
    const std::vector<uint32_t>& spirv = plan_->modules[*pass.module];
    VkShaderModuleCreateInfo module_create{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    module_create.codeSize = spirv.size() * sizeof(uint32_t);
    module_create.pCode = spirv.data();
    VkShaderModule module = VK_NULL_HANDLE;
    require(device_->vk().vkCreateShaderModule(device_->get(), &module_create, nullptr, &module),
            "vkCreateShaderModule", pass.node);
    const Held<VkShaderModule> held_module(*device_, module);

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
    require(
        device_->vk().vkCreateComputePipelines(device_->get(), cache_.get(), 1, &create, nullptr, &pipeline),
        "vkCreateComputePipelines", pass.node);
    out.pipeline = {*device_, pipeline};
    device_->name(VK_OBJECT_TYPE_PIPELINE, pipeline, pass.node);
    return out;
}

void ProgramState::record_uploads(VkCommandBuffer cmd) const {
    // Another view's frame may have done the same and be reading: its reads come first, and the texels that
    // replace what they saw are the same.
    struct Stand {  // of an image, before or after
        VkImageLayout layout;
        VkPipelineStageFlags2 stages;
        VkAccessFlags2 access;
    };
    constexpr Stand fresh{VK_IMAGE_LAYOUT_UNDEFINED, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                          VK_ACCESS_2_NONE},
        filled{VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_2_COPY_BIT,
               VK_ACCESS_2_TRANSFER_WRITE_BIT},
        read{VK_IMAGE_LAYOUT_GENERAL, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
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
        barrier.subresourceRange = {aspects_of(format), 0, 1, 0, 1};
        VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
        dependency.imageMemoryBarrierCount = 1;
        dependency.pImageMemoryBarriers = &barrier;
        device_->vk().vkCmdPipelineBarrier2(cmd, &dependency);
    };
    for (size_t i = 0; i < tables_.size(); ++i) {
        const PlanTable& plan = plan_->tables[i];
        const VkImage image = tables_[i].image.image.get();
        bring(image, plan.format, fresh, filled);
        VkBufferImageCopy copy{};
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.imageExtent = {plan.extent[0], plan.extent[1], 1};
        device_->vk().vkCmdCopyBufferToImage(cmd, tables_[i].staging.get(), image, filled.layout, 1, &copy);
        bring(image, plan.format, filled, read);
    }
    for (const auto& [key, stand_in] : absent_images_) bring(stand_in.image.get(), key.format, fresh, read);
}

uint64_t ProgramState::bytes() const {
    uint64_t sum = absent_buffer_.allocated();
    for (const TableImage& table : tables_) sum += table.image.memory.bytes() + table.staging.allocated();
    for (const auto& [key, image] : absent_images_) sum += image.memory.bytes();
    return sum;
}

Program::Program(const DeviceHandles& handles, std::shared_ptr<const Plan> plan,
                 const ProgramOptions& options) {
    if (!plan) fail(ErrorCode::usage, "Program", "the plan is null");
    state_ = std::make_unique<const ProgramState>(handles, std::move(plan), options);
}
Program::~Program() = default;

const DeviceHandles& Program::handles() const {
    return state_->device()->handles();
}

const Plan& Program::plan() const {
    return state_->plan();
}

std::vector<std::byte> Program::pipeline_cache() const {
    const GraphDevice& device = *state_->device();
    size_t size = 0;
    require(device.vk().vkGetPipelineCacheData(device.get(), state_->cache(), &size, nullptr),
            "vkGetPipelineCacheData", plan().pipeline);
    std::vector<std::byte> data(size);
    require(device.vk().vkGetPipelineCacheData(device.get(), state_->cache(), &size, data.data()),
            "vkGetPipelineCacheData", plan().pipeline);
    data.resize(size);
    return data;
}

void Program::record_uploads(VkCommandBuffer cmd) const {
    if (cmd == VK_NULL_HANDLE)
        fail(ErrorCode::usage, "Program::record_uploads", "the command buffer is null");
    state_->record_uploads(cmd);
}

std::shared_ptr<const TransientMemory> Program::make_transients() const {
    const Program* const one = this;
    return penumbra::make_transients({&one, 1});
}

uint64_t Program::bytes() const {
    return state_->bytes();
}

std::shared_ptr<const TransientMemory> make_transients(std::span<const Program* const> programs) {
    std::vector<const Plan*> plans;
    for (const Program* program : programs) {
        if (!program) fail(ErrorCode::usage, "make_transients", "a program is null");
        if (program->handles().device != programs.front()->handles().device)
            fail(ErrorCode::usage, "make_transients", "the programs are on different devices");
        plans.push_back(&program->plan());
    }
    if (plans.empty()) fail(ErrorCode::usage, "make_transients", "there is no program");
    return std::make_shared<const TransientMemory>(programs.front()->state().device(), plans);
}

uint64_t bytes_of(const TransientMemory& memory) {
    return memory.bytes();
}

}  // namespace penumbra
