// SPDX-License-Identifier: MIT
#include "tests/plan_objects.h"

#include <algorithm>
#include <cstring>

namespace penumbra::test {

PlanObjects::PlanObjects(const std::filesystem::path& folder) {
    const std::vector<std::byte> text = read_bytes(folder / "plan.json");
    plan = Json::parse(reinterpret_cast<const char*>(text.data()),
                       reinterpret_cast<const char*>(text.data() + text.size()));
    if (plan["penumbra_plan"] != 2) throw std::runtime_error("a plan of another version");
    for (const Json& heap : plan["heaps"]) heaps.push_back(make_heap(heap));
    for (const Json& r : plan["resources"]) {
        std::vector<Instance>& both = resources.emplace_back();
        for (size_t p = 0; p < (r["kept"] ? 1u : 2u); ++p) both.push_back(make_resource(r, p));
    }
    for (const Json& table : plan["tables"]) {
        const VkExtent2D size{table["size"][0], table["size"][1]};
        tables.push_back(make_image(gpu(), formats.at(table["format"]), size, 1,
                                    VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                                        (table["storage"] ? VK_IMAGE_USAGE_STORAGE_BIT : 0),
                                    "table"));
        const GpuImage& image = tables.back();
        upload_image(gpu(), tables.back(), read_bytes(folder / table["file"].get<std::string>()));
        gpu().run([&](VkCommandBuffer commands) {
            full_barrier(commands, image.get(), image.format, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                         VK_IMAGE_LAYOUT_GENERAL);
        });
    }
    nearest = make_sampler(VK_FILTER_NEAREST);
    linear = make_sampler(VK_FILTER_LINEAR);
    for (const Json& pass : plan["passes"]) passes.push_back(make_pass(pass, folder));
    const VkDescriptorPoolSize sizes[] = {
        {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1000}, {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1000},
        {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, 1000},   {VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER, 1000},
        {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1000},         {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1000}};
    VkDescriptorPoolCreateInfo create{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    create.maxSets = 1000;
    create.poolSizeCount = 6;
    create.pPoolSizes = sizes;
    VkDescriptorPool handle = VK_NULL_HANDLE;
    check(vkCreateDescriptorPool(device(), &create, nullptr, &handle), "vkCreateDescriptorPool", "");
    pool = {device(), handle};
    block =
        make_host_buffer(gpu(), plan["frame_block"]["bytes"], VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, "block");
    counters = make_host_buffer(gpu(), 4 * std::max<size_t>(plan["counters"].size(), 1),
                                VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "counters");
    nothing = make_host_buffer(gpu(), 16384,
                               VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                   VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT |
                                   VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT,
                               "nothing");
}

Owned<VkDeviceMemory> PlanObjects::make_heap(const Json& heap) const {
    const VkPhysicalDeviceMemoryProperties& memory = gpu().memory();
    uint32_t type = 0;
    while (!(heap["memory_type_bits"].get<uint32_t>() >> type & 1) ||
           !(memory.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT))
        ++type;
    const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr,
                                    std::max<uint64_t>(heap["bytes"].get<uint64_t>(), 1), type};
    VkDeviceMemory handle = VK_NULL_HANDLE;
    check(vkAllocateMemory(device(), &info, nullptr, &handle), "vkAllocateMemory", "a heap");
    return {device(), handle};
}

Owned<VkImageView> PlanObjects::view_of(const Json& r, VkImage image, uint32_t level, uint32_t levels) const {
    VkImageViewCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    create.image = image;
    create.viewType = r["array"] ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    create.format = formats.at(r["format"]);
    create.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, level, levels, 0, r["layers"]};
    VkImageView handle = VK_NULL_HANDLE;
    check(vkCreateImageView(device(), &create, nullptr, &handle), "vkCreateImageView", "a resource");
    return {device(), handle};
}

Instance PlanObjects::make_resource(const Json& r, size_t p) const {
    Instance out;
    const VkDeviceMemory heap = heaps[r["heap"]].get();
    const VkDeviceSize offset = r["offset"][p];
    if (r["kind"] == "image") {
        VkImageCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
        create.flags = VK_IMAGE_CREATE_ALIAS_BIT;
        create.imageType = VK_IMAGE_TYPE_2D;
        create.format = formats.at(r["format"]);
        create.extent = {r["size"][0], r["size"][1], 1};
        create.mipLevels = r["levels"];
        create.arrayLayers = r["layers"];
        create.samples = VK_SAMPLE_COUNT_1_BIT;
        create.usage = flags(r["usage"], image_usages);
        create.tiling = r["row_bytes"].is_null() ? VK_IMAGE_TILING_OPTIMAL : VK_IMAGE_TILING_LINEAR;
        VkImage handle = VK_NULL_HANDLE;
        check(vkCreateImage(device(), &create, nullptr, &handle), "vkCreateImage", "a resource");
        out.image = {device(), handle};
        check(vkBindImageMemory(device(), handle, heap, offset), "vkBindImageMemory", "a resource");
        out.views.push_back(view_of(r, handle, 0, create.mipLevels));
        for (uint32_t level = 0; level < create.mipLevels; ++level)
            out.views.push_back(view_of(r, handle, level, 1));
        if (r["row_bytes"].is_null()) return out;
    }
    VkBufferCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    create.size = r["buffer_bytes"];
    create.usage = r["row_bytes"].is_null() ? flags(r["usage"], buffer_usages)
                                            : VkBufferUsageFlags{VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    VkBuffer handle = VK_NULL_HANDLE;
    check(vkCreateBuffer(device(), &create, nullptr, &handle), "vkCreateBuffer", "a resource");
    out.buffer = {device(), handle};
    check(vkBindBufferMemory(device(), handle, heap, offset), "vkBindBufferMemory", "a resource");
    if (create.usage & VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT) out.texels = texels_of(handle, r["format"]);
    return out;
}

Owned<VkBufferView> PlanObjects::texels_of(VkBuffer buffer, const std::string& format) const {
    const VkBufferViewCreateInfo create{
        VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO, nullptr, 0, buffer, formats.at(format), 0, VK_WHOLE_SIZE};
    VkBufferView handle = VK_NULL_HANDLE;
    check(vkCreateBufferView(device(), &create, nullptr, &handle), "vkCreateBufferView", "texels");
    return {device(), handle};
}

Owned<VkSampler> PlanObjects::make_sampler(VkFilter filter) const {
    VkSamplerCreateInfo create{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    create.magFilter = create.minFilter = filter;
    create.addressModeU = create.addressModeV = create.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    create.maxLod = VK_LOD_CLAMP_NONE;
    VkSampler handle = VK_NULL_HANDLE;
    check(vkCreateSampler(device(), &create, nullptr, &handle), "vkCreateSampler", "");
    return {device(), handle};
}

Pass PlanObjects::make_pass(const Json& pass, const std::filesystem::path& folder) const {
    Pass out;
    if (pass["kind"] != "compute") throw std::runtime_error("this executor runs compute passes alone");
    std::vector<VkDescriptorSetLayoutBinding> sets[2];
    for (const Json& b : pass["bindings"])
        sets[b["set"].get<size_t>()].push_back(
            {b["binding"], descriptor_types.at(b["type"]), 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    VkDescriptorSetLayout layouts[2];
    for (size_t s = 0; s < 2; ++s) {
        VkDescriptorSetLayoutCreateInfo create{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
        create.bindingCount = static_cast<uint32_t>(sets[s].size());
        create.pBindings = sets[s].data();
        check(vkCreateDescriptorSetLayout(device(), &create, nullptr, &layouts[s]),
              "vkCreateDescriptorSetLayout", "");
        out.layouts[s] = {device(), layouts[s]};
    }
    const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0,
                                   static_cast<uint32_t>(4 * pass["push"].size())};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 2;
    layout.pSetLayouts = layouts;
    layout.pushConstantRangeCount = push.size ? 1 : 0;
    layout.pPushConstantRanges = &push;
    VkPipelineLayout layout_handle = VK_NULL_HANDLE;
    check(vkCreatePipelineLayout(device(), &layout, nullptr, &layout_handle), "vkCreatePipelineLayout", "");
    out.layout = {device(), layout_handle};

    const std::vector<std::byte> spirv =
        read_bytes(folder / plan["modules"][pass["module"].get<size_t>()].get<std::string>());
    VkShaderModuleCreateInfo module{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    module.codeSize = spirv.size();
    module.pCode = reinterpret_cast<const uint32_t*>(spirv.data());
    VkShaderModule module_handle = VK_NULL_HANDLE;
    check(vkCreateShaderModule(device(), &module, nullptr, &module_handle), "vkCreateShaderModule", "");
    const Owned<VkShaderModule> owned(device(), module_handle);
    const auto constants = pass["constants"].get<std::vector<uint32_t>>();
    std::vector<VkSpecializationMapEntry> entries;
    for (uint32_t id = 0; id < constants.size(); ++id) entries.push_back({id, 4 * id, 4});
    const VkSpecializationInfo specialisation{static_cast<uint32_t>(entries.size()), entries.data(),
                                              4 * constants.size(), constants.data()};
    const std::string entry = pass["entry"];
    VkComputePipelineCreateInfo create{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    create.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    create.stage.module = module_handle;
    create.stage.pName = entry.c_str();
    create.stage.pSpecializationInfo = &specialisation;
    create.layout = layout_handle;
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateComputePipelines(device(), VK_NULL_HANDLE, 1, &create, nullptr, &pipeline),
          "vkCreateComputePipelines", "");
    out.pipeline = {device(), pipeline};
    return out;
}

}  // namespace penumbra::test
