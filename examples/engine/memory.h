// SPDX-License-Identifier: MIT
// The engine's allocator: blocks of a memory type, filled from the front; a block that nobody uses any more
// begins anew. Its buffers and images, and penumbra's requests, come from the same.
#pragma once

#include <penumbra/device.h>

#include <algorithm>

#include "device.h"

namespace engine {

struct Block {
    VkDeviceMemory memory;
    uint32_t type, users = 0;
    bool linear;
    VkDeviceSize size, filled = 0;
    char* mapped = nullptr;
};
inline std::vector<Block> blocks;

struct Place {
    size_t block;
    VkDeviceSize offset;
};

inline Place allocate(const VkMemoryRequirements& need, VkMemoryPropertyFlags wanted, bool linear) {
    VkPhysicalDeviceMemoryProperties types;
    vkGetPhysicalDeviceMemoryProperties(physical, &types);
    uint32_t type = 0;
    while (!(need.memoryTypeBits >> type & 1) || (types.memoryTypes[type].propertyFlags & wanted) != wanted)
        ++type;
    const auto offset_in = [&](const Block& b) {
        return (b.filled + need.alignment - 1) / need.alignment * need.alignment;
    };
    size_t at = 0;
    while (at < blocks.size() && (blocks[at].type != type || blocks[at].linear != linear ||
                                  offset_in(blocks[at]) + need.size > blocks[at].size))
        ++at;
    if (at == blocks.size()) {
        Block block{VK_NULL_HANDLE, type, 0, linear, std::max<VkDeviceSize>(need.size, 4 << 20)};
        const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, block.size, type};
        must(vkAllocateMemory(device, &info, nullptr, &block.memory), "vkAllocateMemory");
        void* mapped = nullptr;
        if (types.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT)
            must(vkMapMemory(device, block.memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
        block.mapped = static_cast<char*>(mapped);
        blocks.push_back(block);
    }
    const Place place{at, offset_in(blocks[at])};
    blocks[at].filled = place.offset + need.size;
    ++blocks[at].users;
    return place;
}

inline void release(size_t block) {
    if (--blocks[block].users == 0) blocks[block].filled = 0;
}

// The same for penumbra: each request is one of the allocator's.
inline pen::HostMemory memory_of_the_engine() {
    return {[](const pen::MemoryRequest& request, pen::MemoryBlock& out) {
                const Place place = allocate(request.need, request.properties, request.linear);
                const Block& block = blocks[place.block];
                out = {block.memory, place.offset, block.mapped ? block.mapped + place.offset : nullptr,
                       reinterpret_cast<void*>(place.block)};
                return VK_SUCCESS;
            },
            [](const pen::MemoryBlock& block) { release(reinterpret_cast<size_t>(block.user)); }};
}

struct Buffer {
    VkBuffer handle = VK_NULL_HANDLE;
    VkBufferView texels = VK_NULL_HANDLE;
    Place place{};
    char* mapped() const { return blocks[place.block].mapped + place.offset; }
};

inline Buffer make_buffer(VkDeviceSize size, VkFormat texels) {
    Buffer b;
    VkBufferCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    create.size = size;
    create.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                   VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                   VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT;
    must(vkCreateBuffer(device, &create, nullptr, &b.handle), "vkCreateBuffer");
    VkMemoryRequirements need;
    vkGetBufferMemoryRequirements(device, b.handle, &need);
    b.place =
        allocate(need, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT, true);
    must(vkBindBufferMemory(device, b.handle, blocks[b.place.block].memory, b.place.offset),
         "vkBindBufferMemory");
    if (texels == VK_FORMAT_UNDEFINED) return b;
    const VkBufferViewCreateInfo view{
        VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO, nullptr, 0, b.handle, texels, 0, VK_WHOLE_SIZE};
    must(vkCreateBufferView(device, &view, nullptr, &b.texels), "vkCreateBufferView");
    return b;
}

inline void destroy(const Buffer& b) {
    vkDestroyBufferView(device, b.texels, nullptr);
    vkDestroyBuffer(device, b.handle, nullptr);
    release(b.place.block);
}

struct Access {
    VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_NONE;
    VkAccessFlags2 access = VK_ACCESS_2_NONE;
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
    bool write = false;
};

struct Image {
    VkImage handle = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT;
    VkExtent3D extent{};
    uint32_t layers = 1;
    Place place{};
    Access last;  // how it was used last
};

// `array`: of so many layers, be it one.
inline Image make_image(VkFormat format, VkExtent3D extent, VkImageUsageFlags usage, bool array,
                        uint32_t layers) {
    Image image;
    image.extent = extent;
    image.layers = layers;
    if (format == VK_FORMAT_D32_SFLOAT) image.aspect = VK_IMAGE_ASPECT_DEPTH_BIT;
    VkImageCreateInfo create{
        VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO, nullptr, 0, VK_IMAGE_TYPE_2D, format, extent};
    create.mipLevels = 1;
    create.arrayLayers = layers;
    create.samples = VK_SAMPLE_COUNT_1_BIT;
    create.usage = usage;
    must(vkCreateImage(device, &create, nullptr, &image.handle), "vkCreateImage");
    VkMemoryRequirements need;
    vkGetImageMemoryRequirements(device, image.handle, &need);
    image.place = allocate(need, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, false);
    must(vkBindImageMemory(device, image.handle, blocks[image.place.block].memory, image.place.offset),
         "vkBindImageMemory");
    const VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                     nullptr,
                                     0,
                                     image.handle,
                                     array ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D,
                                     format,
                                     {},
                                     {image.aspect, 0, 1, 0, layers}};
    must(vkCreateImageView(device, &view, nullptr, &image.view), "vkCreateImageView");
    return image;
}

inline void destroy(const Image& image) {
    vkDestroyImageView(device, image.view, nullptr);
    vkDestroyImage(device, image.handle, nullptr);
    release(image.place.block);
}

// At the engine's end: what is still in use has leaked.
inline void free_blocks() {
    for (const Block& block : blocks) {
        if (block.users) std::fprintf(stderr, "memory has leaked\n"), ++messages;
        vkFreeMemory(device, block.memory, nullptr);
    }
    blocks.clear();
}

}  // namespace engine
