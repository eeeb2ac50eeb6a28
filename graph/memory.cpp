// SPDX-License-Identifier: MIT
// Sizes are asked from the device before anything is created (vkGetDevice*MemoryRequirements, Vulkan 1.3), so
// that a plan for a device is final before its memory exists.
#include "penumbra/memory.h"

#include <fmt/format.h>

namespace penumbra {
namespace {

VkImageCreateInfo image_info(const ImageNeed& need) {
    VkImageCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    create.imageType = VK_IMAGE_TYPE_2D;
    create.format = info(need.format).vk;
    create.extent = {need.extent.width, need.extent.height, 1};
    create.mipLevels = need.levels;
    create.arrayLayers = need.layers;
    create.samples = VK_SAMPLE_COUNT_1_BIT;
    create.tiling = VK_IMAGE_TILING_OPTIMAL;
    create.usage = need.usage;
    create.flags = VK_IMAGE_CREATE_ALIAS_BIT;
    return create;
}

VkBufferCreateInfo buffer_info(uint64_t bytes, VkBufferUsageFlags usage) {
    VkBufferCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    create.size = bytes;
    create.usage = usage;
    return create;
}

Owned<VkDeviceMemory> allocate(const DeviceHandles& handles, VkDeviceSize bytes, uint32_t type,
                               std::string_view what) {
    VkMemoryAllocateInfo allocate_info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, bytes, type};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    check(vkAllocateMemory(handles.device, &allocate_info, nullptr, &memory), "vkAllocateMemory",
          fmt::format("{}, {} bytes", what, bytes));
    return {handles.device, memory};
}

Owned<VkImageView> image_view(const DeviceHandles& handles, const PlanResource& r, VkImage image,
                              uint32_t first_level, uint32_t levels) {
    VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view.image = image;
    view.viewType = r.layered ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    view.format = info(r.format).vk;
    view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, first_level, levels, 0, r.layers};
    VkImageView handle = VK_NULL_HANDLE;
    check(vkCreateImageView(handles.device, &view, nullptr, &handle), "vkCreateImageView", r.names.front());
    return {handles.device, handle};
}

void make_image(const DeviceHandles& handles, const PlanResource& r, VkDeviceMemory heap, VkDeviceSize offset,
                ResourceInstance& out) {
    const std::string& name = r.names.front();
    const VkImageCreateInfo create = image_info({r.format, r.extent, r.layers, r.levels, r.image_usage});
    VkImage image = VK_NULL_HANDLE;
    check(vkCreateImage(handles.device, &create, nullptr, &image), "vkCreateImage", name);
    out.image = {handles.device, image};
    check(vkBindImageMemory(handles.device, image, heap, offset), "vkBindImageMemory", name);
    out.image_view = image_view(handles, r, image, 0, r.levels);
    for (uint32_t level = 0; level < r.levels && r.levels > 1; ++level)
        out.level_views.push_back(image_view(handles, r, image, level, 1));
}

void make_buffer(const DeviceHandles& handles, const PlanResource& r, VkDeviceMemory heap,
                 VkDeviceSize offset, ResourceInstance& out) {
    const std::string& name = r.names.front();
    const VkBufferCreateInfo create = buffer_info(r.buffer_bytes(), r.buffer_usage);
    VkBuffer buffer = VK_NULL_HANDLE;
    check(vkCreateBuffer(handles.device, &create, nullptr, &buffer), "vkCreateBuffer", name);
    out.buffer = {handles.device, buffer};
    check(vkBindBufferMemory(handles.device, buffer, heap, offset), "vkBindBufferMemory", name);
    out.bytes = r.buffer_bytes();
    if (!(r.buffer_usage & VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT)) return;
    VkBufferViewCreateInfo view{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
    view.buffer = buffer;
    view.format = info(r.format).vk;
    view.range = VK_WHOLE_SIZE;
    VkBufferView handle = VK_NULL_HANDLE;
    check(vkCreateBufferView(handles.device, &view, nullptr, &handle), "vkCreateBufferView", name);
    out.buffer_view = {handles.device, handle};
}

}  // namespace

DeviceTable device_table(const DeviceHandles& handles) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(handles.physical, &properties);
    DeviceTable table;
    table.name = properties.deviceName;
    table.cpu = properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    table.max_image_extent = properties.limits.maxImageDimension2D;
    table.max_texel_elements = properties.limits.maxTexelBufferElements;
    table.max_storage_bytes = properties.limits.maxStorageBufferRange;
    table.max_workgroup_invocations = properties.limits.maxComputeWorkGroupInvocations;
    const VkDevice device = handles.device;
    table.image_memory = [device](const ImageNeed& need) {
        const VkImageCreateInfo create = image_info(need);
        const VkDeviceImageMemoryRequirements ask{
            VK_STRUCTURE_TYPE_DEVICE_IMAGE_MEMORY_REQUIREMENTS, nullptr, &create, {}};
        VkMemoryRequirements2 answer{VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
        vkGetDeviceImageMemoryRequirements(device, &ask, &answer);
        return MemoryNeed{answer.memoryRequirements.size, answer.memoryRequirements.alignment,
                          answer.memoryRequirements.memoryTypeBits};
    };
    table.buffer_memory = [device](uint64_t bytes, VkBufferUsageFlags usage) {
        const VkBufferCreateInfo create = buffer_info(bytes, usage);
        const VkDeviceBufferMemoryRequirements ask{VK_STRUCTURE_TYPE_DEVICE_BUFFER_MEMORY_REQUIREMENTS,
                                                   nullptr, &create};
        VkMemoryRequirements2 answer{VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
        vkGetDeviceBufferMemoryRequirements(device, &ask, &answer);
        return MemoryNeed{answer.memoryRequirements.size, answer.memoryRequirements.alignment,
                          answer.memoryRequirements.memoryTypeBits};
    };
    const VkPhysicalDevice physical = handles.physical;
    table.supports = [physical](Format format, VkFormatFeatureFlags features) {
        VkFormatProperties supported;
        vkGetPhysicalDeviceFormatProperties(physical, info(format).vk, &supported);
        // Image and buffer features are different bits.
        return ((supported.optimalTilingFeatures | supported.bufferFeatures) & features) == features;
    };
    return table;
}

uint32_t memory_type(VkPhysicalDevice physical, uint32_t type_bits, VkMemoryPropertyFlags wanted) {
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(physical, &memory);
    for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
        if ((type_bits >> i & 1) && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    throw VulkanError(VK_ERROR_FEATURE_NOT_PRESENT,
                      fmt::format("no memory type of {:#x} has the properties {:#x}", type_bits, wanted));
}

MappedBuffer::MappedBuffer(const DeviceHandles& handles, VkDeviceSize bytes, VkBufferUsageFlags usage,
                           std::string_view what)
    : size_(bytes) {
    const VkBufferCreateInfo create = buffer_info(bytes, usage);
    VkBuffer buffer = VK_NULL_HANDLE;
    check(vkCreateBuffer(handles.device, &create, nullptr, &buffer), "vkCreateBuffer", what);
    buffer_ = {handles.device, buffer};
    VkMemoryRequirements need;
    vkGetBufferMemoryRequirements(handles.device, buffer, &need);
    const uint32_t type =
        memory_type(handles.physical, need.memoryTypeBits,
                    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    memory_ = allocate(handles, need.size, type, what);
    check(vkBindBufferMemory(handles.device, buffer, memory_.get(), 0), "vkBindBufferMemory", what);
    void* mapped = nullptr;
    check(vkMapMemory(handles.device, memory_.get(), 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory", what);
    data_ = static_cast<std::byte*>(mapped);
}

PlanMemory::PlanMemory(const DeviceHandles& handles, const Plan& plan) : instances_(plan.resources.size()) {
    for (const Heap& heap : plan.heaps)
        heaps_.push_back(allocate(
            handles, std::max<uint64_t>(heap.bytes, 1),
            memory_type(handles.physical, heap.memory_type_bits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT),
            "the heap of " + heap.type));
    for (uint32_t i = 0; i < plan.resources.size(); ++i) {
        const PlanResource& r = plan.resources[i];
        kept_.push_back(r.kept);
        for (uint32_t parity = 0; parity < (r.kept ? 1u : 2u); ++parity)
            (r.kind == PortKind::image ? make_image : make_buffer)(handles, r, heaps_[r.heap].get(),
                                                                   r.offset[parity], instances_[i][parity]);
    }
}

}  // namespace penumbra
