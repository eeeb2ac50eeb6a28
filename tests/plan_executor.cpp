// SPDX-License-Identifier: MIT
#include "tests/plan_executor.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tests/gpu_test.h"

namespace penumbra::test {
namespace {

using Json = nlohmann::json;

// The words of the JSON, as docs/embedding.md spells them out.
const std::map<std::string, VkFormat> formats = {{"r8", VK_FORMAT_R8_UNORM},
                                                 {"rg8", VK_FORMAT_R8G8_UNORM},
                                                 {"rgba8", VK_FORMAT_R8G8B8A8_UNORM},
                                                 {"r16f", VK_FORMAT_R16_SFLOAT},
                                                 {"rg16f", VK_FORMAT_R16G16_SFLOAT},
                                                 {"rgba16f", VK_FORMAT_R16G16B16A16_SFLOAT},
                                                 {"r32f", VK_FORMAT_R32_SFLOAT},
                                                 {"rg32f", VK_FORMAT_R32G32_SFLOAT},
                                                 {"rgba32f", VK_FORMAT_R32G32B32A32_SFLOAT},
                                                 {"r32ui", VK_FORMAT_R32_UINT},
                                                 {"rg32ui", VK_FORMAT_R32G32_UINT},
                                                 {"rgba32ui", VK_FORMAT_R32G32B32A32_UINT},
                                                 {"rgb10a2", VK_FORMAT_A2B10G10R10_UNORM_PACK32},
                                                 {"r11g11b10f", VK_FORMAT_B10G11R11_UFLOAT_PACK32},
                                                 {"d32", VK_FORMAT_D32_SFLOAT},
                                                 {"d16", VK_FORMAT_D16_UNORM}};
const std::map<std::string, VkPipelineStageFlags2> stages = {
    {"compute", VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT}, {"indirect", VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT},
    {"transfer", VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT},  {"copy", VK_PIPELINE_STAGE_2_COPY_BIT},
    {"top", VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT},        {"all", VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT}};
const std::map<std::string, VkAccessFlags2> accesses = {
    {"write", VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT},      {"read", VK_ACCESS_2_SHADER_STORAGE_READ_BIT},
    {"sample", VK_ACCESS_2_SHADER_SAMPLED_READ_BIT},      {"uniform", VK_ACCESS_2_UNIFORM_READ_BIT},
    {"arguments", VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT}, {"copy_read", VK_ACCESS_2_TRANSFER_READ_BIT},
    {"copy_write", VK_ACCESS_2_TRANSFER_WRITE_BIT},       {"any_read", VK_ACCESS_2_MEMORY_READ_BIT},
    {"any_write", VK_ACCESS_2_MEMORY_WRITE_BIT}};
const std::map<std::string, VkImageUsageFlags> image_usages = {
    {"storage", VK_IMAGE_USAGE_STORAGE_BIT},
    {"sampled", VK_IMAGE_USAGE_SAMPLED_BIT},
    {"copy_source", VK_IMAGE_USAGE_TRANSFER_SRC_BIT},
    {"copy_target", VK_IMAGE_USAGE_TRANSFER_DST_BIT}};
const std::map<std::string, VkBufferUsageFlags> buffer_usages = {
    {"storage", VK_BUFFER_USAGE_STORAGE_BUFFER_BIT},
    {"texels", VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT},
    {"arguments", VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT},
    {"copy_source", VK_BUFFER_USAGE_TRANSFER_SRC_BIT},
    {"copy_target", VK_BUFFER_USAGE_TRANSFER_DST_BIT}};
const std::map<std::string, VkDescriptorType> descriptor_types = {
    {"sampled_image", VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
    {"storage_image", VK_DESCRIPTOR_TYPE_STORAGE_IMAGE},
    {"texel_buffer", VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER},
    {"uniform_buffer", VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
    {"storage_buffer", VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}};

template <class Flags>
Flags flags(const Json& list, const std::map<std::string, Flags>& words) {
    Flags sum = 0;
    for (const Json& word : list) sum |= words.at(word.get<std::string>());
    return sum;
}

std::vector<std::byte> read(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw std::runtime_error("cannot read " + file.string());
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

constexpr VkImageSubresourceRange whole{VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0,
                                        VK_REMAINING_ARRAY_LAYERS};

struct Instance {
    Owned<VkImage> image;
    std::vector<Owned<VkImageView>> views;  // the whole, then each level
    Owned<VkBuffer> buffer;
    Owned<VkBufferView> texels;
};

struct Pass {
    Owned<VkDescriptorSetLayout> layouts[2];
    Owned<VkPipelineLayout> layout;
    Owned<VkPipeline> pipeline;
};

}  // namespace

struct PlanExecutor::Parts {
    Json plan;
    std::vector<Owned<VkDeviceMemory>> heaps;
    std::vector<std::vector<Instance>> resources;  // by parity; what is kept has one
    std::vector<Pass> passes;
    std::vector<GpuImage> tables;
    Owned<VkSampler> nearest, linear;
    Owned<VkDescriptorPool> pool;
    GpuBuffer block, counters, nothing;
    std::map<std::string, GpuImage> no_image;
    std::map<std::string, Owned<VkBufferView>> no_texels;
    std::vector<GpuImage> slot_images;  // of this frame, by slot
    std::vector<GpuTexels> slot_texels;
    std::vector<GpuBuffer> slot_buffers;
    uint32_t frames = 0, parity = 0;

    VkDevice device() const { return gpu().get(); }

    explicit Parts(const std::filesystem::path& folder) {
        const std::vector<std::byte> text = read(folder / "plan.json");
        plan = Json::parse(reinterpret_cast<const char*>(text.data()),
                           reinterpret_cast<const char*>(text.data() + text.size()));
        if (plan["penumbra_plan"] != 1) throw std::runtime_error("a plan of another version");
        for (const Json& heap : plan["heaps"]) heaps.push_back(make_heap(heap));
        for (const Json& r : plan["resources"]) {
            std::vector<Instance>& both = resources.emplace_back();
            for (size_t p = 0; p < (r["kept"] ? 1u : 2u); ++p) both.push_back(make_resource(r, p));
        }
        for (const Json& table : plan["tables"]) {
            const VkExtent2D size{table["size"][0], table["size"][1]};
            tables.push_back(make_image(gpu(), formats.at(table["format"]), size, 1,
                                        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                                        "table"));
            upload_image(gpu(), tables.back(), read(folder / table["file"].get<std::string>()));
        }
        nearest = make_sampler(VK_FILTER_NEAREST);
        linear = make_sampler(VK_FILTER_LINEAR);
        for (const Json& pass : plan["passes"]) passes.push_back(make_pass(pass, folder));
        const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1000},
                                              {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1000},
                                              {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, 1000},
                                              {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1000},
                                              {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1000}};
        VkDescriptorPoolCreateInfo create{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
        create.maxSets = 1000;
        create.poolSizeCount = 5;
        create.pPoolSizes = sizes;
        VkDescriptorPool handle = VK_NULL_HANDLE;
        check(vkCreateDescriptorPool(device(), &create, nullptr, &handle), "vkCreateDescriptorPool", "");
        pool = {device(), handle};
        block = make_host_buffer(gpu(), plan["frame_block"]["bytes"], VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                                 "block");
        counters = make_host_buffer(gpu(), 4 * std::max<size_t>(plan["counters"].size(), 1),
                                    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "counters");
        nothing = make_host_buffer(gpu(), 16384,
                                   VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                       VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT,
                                   "nothing");
    }

    Owned<VkDeviceMemory> make_heap(const Json& heap) const {
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

    Owned<VkImageView> view_of(const Json& r, VkImage image, uint32_t level, uint32_t levels) const {
        VkImageViewCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
        create.image = image;
        create.viewType = r["array"] ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
        create.format = formats.at(r["format"]);
        create.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, level, levels, 0, r["layers"]};
        VkImageView handle = VK_NULL_HANDLE;
        check(vkCreateImageView(device(), &create, nullptr, &handle), "vkCreateImageView", "a resource");
        return {device(), handle};
    }

    Instance make_resource(const Json& r, size_t p) const {
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
            VkImage handle = VK_NULL_HANDLE;
            check(vkCreateImage(device(), &create, nullptr, &handle), "vkCreateImage", "a resource");
            out.image = {device(), handle};
            check(vkBindImageMemory(device(), handle, heap, offset), "vkBindImageMemory", "a resource");
            out.views.push_back(view_of(r, handle, 0, create.mipLevels));
            for (uint32_t level = 0; level < create.mipLevels; ++level)
                out.views.push_back(view_of(r, handle, level, 1));
            return out;
        }
        VkBufferCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
        create.size = r["buffer_bytes"];
        create.usage = flags(r["usage"], buffer_usages);
        VkBuffer handle = VK_NULL_HANDLE;
        check(vkCreateBuffer(device(), &create, nullptr, &handle), "vkCreateBuffer", "a resource");
        out.buffer = {device(), handle};
        check(vkBindBufferMemory(device(), handle, heap, offset), "vkBindBufferMemory", "a resource");
        if (create.usage & VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT)
            out.texels = texels_of(handle, r["format"]);
        return out;
    }

    Owned<VkBufferView> texels_of(VkBuffer buffer, const std::string& format) const {
        const VkBufferViewCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                            nullptr,
                                            0,
                                            buffer,
                                            formats.at(format),
                                            0,
                                            VK_WHOLE_SIZE};
        VkBufferView handle = VK_NULL_HANDLE;
        check(vkCreateBufferView(device(), &create, nullptr, &handle), "vkCreateBufferView", "texels");
        return {device(), handle};
    }

    Owned<VkSampler> make_sampler(VkFilter filter) const {
        VkSamplerCreateInfo create{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
        create.magFilter = create.minFilter = filter;
        create.addressModeU = create.addressModeV = create.addressModeW =
            VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
        create.maxLod = VK_LOD_CLAMP_NONE;
        VkSampler handle = VK_NULL_HANDLE;
        check(vkCreateSampler(device(), &create, nullptr, &handle), "vkCreateSampler", "");
        return {device(), handle};
    }

    Pass make_pass(const Json& pass, const std::filesystem::path& folder) const {
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
        check(vkCreatePipelineLayout(device(), &layout, nullptr, &layout_handle), "vkCreatePipelineLayout",
              "");
        out.layout = {device(), layout_handle};

        const std::vector<std::byte> spirv =
            read(folder / plan["modules"][pass["module"].get<size_t>()].get<std::string>());
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

    const Instance& instance(size_t resource, bool previous) const {
        const std::vector<Instance>& both = resources[resource];
        return both.size() == 1 ? both[0] : both[previous ? 1 - parity : parity];
    }

    void bring(const std::map<std::string, std::vector<std::byte>>& slots) {
        slot_images.clear();
        slot_texels.clear();
        slot_buffers.clear();
        for (const Json& slot : plan["slots"]) {
            const std::vector<std::byte>& bytes = slots.at(slot["name"]);
            slot_images.emplace_back();
            slot_texels.emplace_back();
            slot_buffers.emplace_back();
            if (slot["kind"] == "image") {
                slot_images.back() =
                    make_image(gpu(), formats.at(slot["format"]), {slot["size"][0], slot["size"][1]}, 1,
                               VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, "slot");
                upload_image(gpu(), slot_images.back(), bytes);
            } else if (slot["kind"] == "texels") {
                slot_texels.back() = upload_texels(gpu(), bytes, formats.at(slot["format"]), "slot");
            } else {
                slot_buffers.back() = upload_buffer(
                    gpu(), bytes, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                    "slot");
            }
        }
    }

    // 1x1 images that are bound and never read, in the general layout.
    VkImageView no_image_view(const Json& b, VkCommandBuffer cmd) {
        const std::string key = b["format"].get<std::string>() + (b["array"] ? "[]" : "");
        GpuImage& image = no_image[key];
        if (!image.get()) {
            image = (b["array"] ? make_layered_image : make_image)(
                gpu(), formats.at(b["format"]), {1, 1}, 1,
                b["type"] == "storage_image" ? VK_IMAGE_USAGE_STORAGE_BIT : VK_IMAGE_USAGE_SAMPLED_BIT,
                "nothing");
            VkImageMemoryBarrier2 barrier = activation(image.get());
            if (is_depth(image.format)) barrier.subresourceRange.aspectMask = VK_IMAGE_ASPECT_DEPTH_BIT;
            barrier.dstStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
            barrier.dstAccessMask = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
            record_barrier(cmd, nullptr, {barrier});
        }
        return image.view.get();
    }

    static VkImageMemoryBarrier2 activation(VkImage image) {
        VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
        barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
        barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
        barrier.image = image;
        barrier.subresourceRange = whole;
        return barrier;
    }

    static void record_barrier(VkCommandBuffer cmd, const VkMemoryBarrier2* memory,
                               const std::vector<VkImageMemoryBarrier2>& images) {
        VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
        info.memoryBarrierCount = memory ? 1 : 0;
        info.pMemoryBarriers = memory;
        info.imageMemoryBarrierCount = static_cast<uint32_t>(images.size());
        info.pImageMemoryBarriers = images.data();
        if (memory || !images.empty()) vkCmdPipelineBarrier2(cmd, &info);
    }

    void record_dependency(VkCommandBuffer cmd, const Json& d) const {
        VkMemoryBarrier2 memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
        memory.srcStageMask = flags(d["from_stages"], stages);
        memory.srcAccessMask = flags(d["from_access"], accesses);
        memory.dstStageMask = flags(d["to_stages"], stages);
        memory.dstAccessMask = flags(d["to_access"], accesses);
        std::vector<VkImageMemoryBarrier2> images;
        for (const Json& a : d["activations"]) {
            images.push_back(activation(instance(a["resource"], false).image.get()));
            images.back().srcStageMask = flags(a["from_stages"], stages);
            images.back().srcAccessMask = flags(a["from_access"], accesses);
            images.back().dstStageMask = flags(a["to_stages"], stages);
            images.back().dstAccessMask = flags(a["to_access"], accesses);
        }
        record_barrier(cmd, memory.srcStageMask ? &memory : nullptr, images);
    }

    static void record_everything(VkCommandBuffer cmd, std::vector<VkImageMemoryBarrier2> images) {
        constexpr VkAccessFlags2 any = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
        const VkMemoryBarrier2 memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,   nullptr,
                                      VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, any,
                                      VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, any};
        for (VkImageMemoryBarrier2& image : images) {
            image.srcStageMask = image.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
            image.dstAccessMask = any;
        }
        record_barrier(cmd, &memory, images);
    }

    static void record_clear(VkCommandBuffer cmd, const Instance& r) {
        const VkClearColorValue zero{};
        if (r.image)
            vkCmdClearColorImage(cmd, r.image.get(), VK_IMAGE_LAYOUT_GENERAL, &zero, 1, &whole);
        else
            vkCmdFillBuffer(cmd, r.buffer.get(), 0, VK_WHOLE_SIZE, 0);
    }

    VkDescriptorSet fill(const Json& pass, const Pass& objects, uint32_t set, uint32_t level,
                         VkCommandBuffer cmd) {
        const VkDescriptorSetLayout layout = objects.layouts[set].get();
        VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
        allocate.descriptorPool = pool.get();
        allocate.descriptorSetCount = 1;
        allocate.pSetLayouts = &layout;
        VkDescriptorSet handle = VK_NULL_HANDLE;
        check(vkAllocateDescriptorSets(device(), &allocate, &handle), "vkAllocateDescriptorSets", "");
        for (const Json& b : pass["bindings"]) {
            if (b["set"] != set) continue;
            VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
            write.dstSet = handle;
            write.dstBinding = b["binding"];
            write.descriptorCount = 1;
            write.descriptorType = descriptor_types.at(b["type"]);
            VkDescriptorImageInfo image{b["filter"] == "linear" ? linear.get() : nearest.get(),
                                        VK_NULL_HANDLE, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
            VkDescriptorBufferInfo buffer{VK_NULL_HANDLE, 0, VK_WHOLE_SIZE};
            VkBufferView texels = VK_NULL_HANDLE;
            const std::string source = b["source"];
            if (source == "resource") {
                const Instance& r = instance(b["index"], b["previous"]);
                const bool one = b["type"] == "storage_image";
                const size_t which = !one || b["level"] == "finest"   ? 0
                                     : b["level"] == "finer" && level ? level - 1
                                                                      : level;
                if (r.image) image.imageView = r.views[one ? 1 + which : 0].get();
                image.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
                buffer.buffer = r.buffer.get();
                texels = r.texels.get();
            } else if (source == "slot") {
                const size_t s = b["index"];
                image.imageView = slot_images[s].view.get();
                buffer.buffer = slot_buffers[s].get();
                texels = slot_texels[s].view.get();
            } else if (source == "table") {
                image.imageView = tables[b["index"]].view.get();
            } else if (source == "frame_block") {
                buffer.buffer = block.get();
            } else if (source == "counters") {
                buffer.buffer = counters.get();
            } else {
                buffer.buffer = nothing.get();
                if (b["type"] == "texel_buffer") {
                    Owned<VkBufferView>& view = no_texels[b["format"]];
                    if (!view) view = texels_of(nothing.get(), b["format"]);
                    texels = view.get();
                } else if (!b["format"].is_null()) {
                    image.imageView = no_image_view(b, cmd);
                    image.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
                }
            }
            write.pImageInfo = &image;
            write.pBufferInfo = &buffer;
            write.pTexelBufferView = &texels;
            vkUpdateDescriptorSets(device(), 1, &write, 0, nullptr);
        }
        return handle;
    }

    void record_pass(VkCommandBuffer cmd, const Json& pass, const Pass& objects) {
        record_dependency(cmd, pass["before"][parity]);
        for (const Json& resource : pass["clears"]) record_clear(cmd, instance(resource, false));
        record_dependency(cmd, pass["after_clears"][parity]);
        std::vector<Json> dispatches(pass["level_groups"].begin(), pass["level_groups"].end());
        if (dispatches.empty()) dispatches.push_back(pass["groups"]);
        const VkDescriptorSet host = fill(pass, objects, 1, 0, cmd);
        auto push = pass["push"].get<std::vector<uint32_t>>();
        vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, objects.pipeline.get());
        for (uint32_t level = 0; level < dispatches.size(); ++level) {
            if (level) {  // it reads the level before
                const VkMemoryBarrier2 memory{
                    VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,     nullptr,
                    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT};
                record_barrier(cmd, &memory, {});
            }
            const VkDescriptorSet sets[] = {fill(pass, objects, 0, level, cmd), host};
            vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, objects.layout.get(), 0, 2, sets, 0,
                                    nullptr);
            if (!pass["mip_level"].is_null()) push[pass["mip_level"].get<size_t>() / 4] = level;
            if (!push.empty())
                vkCmdPushConstants(cmd, objects.layout.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                                   static_cast<uint32_t>(4 * push.size()), push.data());
            const Json& groups = dispatches[level];
            if (!pass["indirect"].is_null())
                vkCmdDispatchIndirect(cmd, instance(pass["indirect"]["resource"], false).buffer.get(),
                                      pass["indirect"]["offset"]);
            else
                vkCmdDispatch(cmd, groups[0], groups[1], groups[2]);
        }
    }

    void record_reset(VkCommandBuffer cmd) const {
        std::vector<VkImageMemoryBarrier2> images;
        for (const Json& action : plan["reset"])
            if (const Instance& r = instance(action["resource"], true); r.image)
                images.push_back(activation(r.image.get()));
        record_everything(cmd, images);
        for (const Json& action : plan["reset"])
            if (action["clear"]) record_clear(cmd, instance(action["resource"], true));
        record_everything(cmd, {});
    }

    void frame(const std::vector<std::byte>& bytes,
               const std::map<std::string, std::vector<std::byte>>& slots) {
        parity = frames & 1;
        bring(slots);
        if (bytes.size() != plan["frame_block"]["bytes"]) throw std::runtime_error("another frame block");
        std::memcpy(block.mapped, bytes.data(), bytes.size());
        std::memset(counters.mapped, 0, counters.bytes);
        check(vkResetDescriptorPool(device(), pool.get(), 0), "vkResetDescriptorPool", "");
        uint32_t frame_flags = 0;
        for (const Json& member : plan["frame_block"]["members"])
            if (member["name"] == "flags")
                std::memcpy(&frame_flags, bytes.data() + member["offset"].get<size_t>(), 4);
        gpu().run([&](VkCommandBuffer cmd) {
            if (frames == 0 || (frame_flags & 1)) record_reset(cmd);
            for (size_t p = 0; p < passes.size(); ++p) record_pass(cmd, plan["passes"][p], passes[p]);
            record_dependency(cmd, plan["end"][parity]);
        });
        ++frames;
    }

    std::vector<std::byte> output(const std::string& name) const {
        for (const Json& output : plan["outputs"]) {
            if (output["name"] != name) continue;
            const Json& r = plan["resources"][output["resource"].get<size_t>()];
            return read_image(gpu(), instance(output["resource"], false).image.get(), formats.at(r["format"]),
                              {r["size"][0], r["size"][1]}, VK_IMAGE_LAYOUT_GENERAL);
        }
        throw std::invalid_argument("no output " + name);
    }
};

PlanExecutor::PlanExecutor(const std::filesystem::path& folder) : parts_(std::make_unique<Parts>(folder)) {}
PlanExecutor::~PlanExecutor() = default;

void PlanExecutor::frame(const std::vector<std::byte>& frame_block,
                         const std::map<std::string, std::vector<std::byte>>& slots) {
    parts_->frame(frame_block, slots);
}

std::vector<std::string> PlanExecutor::slots() const {
    std::vector<std::string> names;
    for (const Json& slot : parts_->plan["slots"]) names.push_back(slot["name"]);
    return names;
}

std::vector<std::byte> PlanExecutor::output(const std::string& name) const {
    return parts_->output(name);
}

}  // namespace penumbra::test
