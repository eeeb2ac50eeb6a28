// SPDX-License-Identifier: MIT
// Buffers, images, uploads and readbacks, each blocking: they run before the first frame or after the last
// one.
#include "host/device/gpu.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "graph/memory_type.h"

namespace penumbra {

namespace {

// `usage`: of a buffer. The host reads what it sees and commands copy into.
Owned<VkDeviceMemory> allocate(const Device& device, const VkMemoryRequirements& needs,
                               VkMemoryPropertyFlags wanted, VkBufferUsageFlags usage,
                               std::string_view what) {
    const bool readback =
        (wanted & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) && (usage & VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    const auto type = memory_type(device.memory(), needs.memoryTypeBits, wanted, readback);
    if (!type)
        throw DeviceError(fmt::format("{}: no memory type of {} fits {}", what, wanted, device.info().name));
    VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    info.allocationSize = needs.size;
    info.memoryTypeIndex = *type;
    VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
    flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
    if (usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) info.pNext = &flags;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    check(vkAllocateMemory(device.get(), &info, nullptr, &memory), "vkAllocateMemory",
          fmt::format("{}, {} bytes", what, needs.size));
    return {device.get(), memory};
}

GpuBuffer make_buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage,
                      VkMemoryPropertyFlags properties, std::string_view what) {
    // Drivers may take more than they say, and give less than was asked for.
    if (bytes > device.largest_buffer())
        throw DeviceError(
            fmt::format("{}: {} bytes, the device's buffers hold {}", what, bytes, device.largest_buffer()));
    GpuBuffer result;
    result.bytes = bytes;
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = bytes;
    info.usage = usage;
    VkBuffer buffer = VK_NULL_HANDLE;
    check(vkCreateBuffer(device.get(), &info, nullptr, &buffer), "vkCreateBuffer", what);
    result.buffer = {device.get(), buffer};
    VkMemoryRequirements needs{};
    vkGetBufferMemoryRequirements(device.get(), buffer, &needs);
    result.memory = allocate(device, needs, properties, usage, what);
    check(vkBindBufferMemory(device.get(), buffer, result.memory.get(), 0), "vkBindBufferMemory", what);
    return result;
}

VkImageAspectFlags aspect_of(VkFormat format) {
    return is_depth(format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

GpuImage bare_image(const Device& device, VkFormat format, VkExtent2D extent, uint32_t levels,
                    uint32_t layers, VkImageUsageFlags usage, std::string_view what) {
    GpuImage result;
    result.format = format;
    result.extent = extent;
    result.levels = levels;
    result.layers = layers;
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {extent.width, extent.height, 1};
    info.mipLevels = levels;
    info.arrayLayers = layers;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.tiling = VK_IMAGE_TILING_OPTIMAL;
    info.usage = usage;
    VkImage image = VK_NULL_HANDLE;
    check(vkCreateImage(device.get(), &info, nullptr, &image), "vkCreateImage", what);
    result.image = {device.get(), image};
    VkMemoryRequirements needs{};
    vkGetImageMemoryRequirements(device.get(), image, &needs);
    result.memory = allocate(device, needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0, what);
    check(vkBindImageMemory(device.get(), image, result.memory.get(), 0), "vkBindImageMemory", what);
    return result;
}

Owned<VkImageView> make_view(const Device& device, const GpuImage& image, VkImageViewType type,
                             uint32_t first_layer, uint32_t layers, std::string_view what) {
    VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view.image = image.get();
    view.viewType = type;
    view.format = image.format;
    view.subresourceRange = {aspect_of(image.format), 0, image.levels, first_layer, layers};
    VkImageView handle = VK_NULL_HANDLE;
    check(vkCreateImageView(device.get(), &view, nullptr, &handle), "vkCreateImageView", what);
    return {device.get(), handle};
}

}  // namespace

void full_barrier(VkCommandBuffer commands, VkImage image, VkFormat format, VkImageLayout from,
                  VkImageLayout to) {
    VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange = {aspect_of(format), 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
    VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    dependency.imageMemoryBarrierCount = 1;
    dependency.pImageMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(commands, &dependency);
}

bool is_depth(VkFormat format) {
    return format == VK_FORMAT_D32_SFLOAT || format == VK_FORMAT_D16_UNORM;
}

uint32_t texel_bytes(VkFormat format) {
    switch (format) {
        case VK_FORMAT_R8_UNORM:
            return 1;
        case VK_FORMAT_R8G8_UNORM:
        case VK_FORMAT_R16_SFLOAT:
        case VK_FORMAT_D16_UNORM:
            return 2;
        case VK_FORMAT_R8G8B8A8_UNORM:
        case VK_FORMAT_R8G8B8A8_SRGB:
        case VK_FORMAT_R16G16_SFLOAT:
        case VK_FORMAT_R32_SFLOAT:
        case VK_FORMAT_R32_UINT:
        case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
        case VK_FORMAT_B10G11R11_UFLOAT_PACK32:
        case VK_FORMAT_D32_SFLOAT:
            return 4;
        case VK_FORMAT_R16G16B16A16_SFLOAT:
        case VK_FORMAT_R32G32_SFLOAT:
        case VK_FORMAT_R32G32_UINT:
            return 8;
        case VK_FORMAT_R32G32B32A32_SFLOAT:
        case VK_FORMAT_R32G32B32A32_UINT:
            return 16;
        default:
            throw std::invalid_argument(
                fmt::format("texel_bytes: VkFormat {} is not known here", int(format)));
    }
}

GpuBuffer make_device_buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage,
                             std::string_view what) {
    return make_buffer(device, bytes, usage, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, what);
}

GpuBuffer make_host_buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage,
                           std::string_view what) {
    GpuBuffer result =
        make_buffer(device, bytes, usage,
                    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT, what);
    check(vkMapMemory(device.get(), result.memory.get(), 0, VK_WHOLE_SIZE, 0, &result.mapped), "vkMapMemory",
          what);
    return result;
}

GpuImage make_image(const Device& device, VkFormat format, VkExtent2D extent, uint32_t levels,
                    VkImageUsageFlags usage, std::string_view what) {
    GpuImage result = bare_image(device, format, extent, levels, 1, usage, what);
    result.view = make_view(device, result, VK_IMAGE_VIEW_TYPE_2D, 0, 1, what);
    return result;
}

GpuImage make_layered_image(const Device& device, VkFormat format, VkExtent2D extent, uint32_t layers,
                            VkImageUsageFlags usage, std::string_view what) {
    GpuImage result = bare_image(device, format, extent, 1, layers, usage, what);
    result.view = make_view(device, result, VK_IMAGE_VIEW_TYPE_2D_ARRAY, 0, layers, what);
    return result;
}

Owned<VkImageView> make_layer_view(const Device& device, const GpuImage& image, uint32_t layer) {
    return make_view(device, image, VK_IMAGE_VIEW_TYPE_2D, layer, 1, "a layer");
}

GpuBuffer upload_buffer(Device& device, std::span<const std::byte> data, VkBufferUsageFlags usage,
                        std::string_view what) {
    const VkDeviceSize bytes = std::max<VkDeviceSize>(data.size(), 16);
    GpuBuffer result = make_device_buffer(device, bytes, usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT, what);
    GpuBuffer staging = make_host_buffer(device, bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, what);
    if (!data.empty()) std::memcpy(staging.mapped, data.data(), data.size());
    std::memset(static_cast<std::byte*>(staging.mapped) + data.size(), 0, bytes - data.size());
    device.run([&](VkCommandBuffer commands) {
        const VkBufferCopy region{0, 0, bytes};
        vkCmdCopyBuffer(commands, staging.get(), result.get(), 1, &region);
    });
    return result;
}

void update_buffer(Device& device, const GpuBuffer& buffer, std::span<const std::byte> data,
                   size_t element_bytes, std::span<const uint32_t> elements, std::string_view what) {
    if (elements.empty()) return;
    const GpuBuffer staging =
        make_host_buffer(device, elements.size() * element_bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, what);
    std::vector<VkBufferCopy> regions;
    for (size_t i = 0; i < elements.size(); ++i) {
        const VkDeviceSize from = i * element_bytes, to = elements[i] * element_bytes;
        std::memcpy(static_cast<std::byte*>(staging.mapped) + from, data.data() + to, element_bytes);
        if (i > 0 && elements[i] == elements[i - 1] + 1)
            regions.back().size += element_bytes;
        else
            regions.push_back({from, to, element_bytes});
    }
    device.run([&](VkCommandBuffer commands) {
        vkCmdCopyBuffer(commands, staging.get(), buffer.get(), uint32_t(regions.size()), regions.data());
    });
}

namespace {

// Read in either way, as a device is faster (DeviceTable::loads_texels).
constexpr VkBufferUsageFlags texel_usage =
    VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT;

GpuTexels with_view(const Device& device, GpuBuffer buffer, VkFormat format, VkDeviceSize bytes,
                    std::string_view what) {
    GpuTexels out{std::move(buffer), {}};
    VkBufferViewCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
    create.buffer = out.buffer.get();
    create.format = format;
    create.range = bytes;
    VkBufferView view = VK_NULL_HANDLE;
    check(vkCreateBufferView(device.get(), &create, nullptr, &view), "vkCreateBufferView", std::string(what));
    out.view = {device.get(), view};
    return out;
}

}  // namespace

GpuTexels upload_texels(Device& device, std::span<const std::byte> data, VkFormat format,
                        std::string_view what) {
    const size_t texels = data.size() / texel_bytes(format);
    if (texels > device.limits().maxTexelBufferElements)
        throw DeviceError(fmt::format("{} need {} texels, the device's texel buffers hold {}", what, texels,
                                      device.limits().maxTexelBufferElements));
    return with_view(device, upload_buffer(device, data, texel_usage, what), format, data.size(), what);
}

GpuTexels make_host_texels(const Device& device, VkDeviceSize bytes, VkFormat format, std::string_view what) {
    return with_view(device, make_host_buffer(device, bytes, texel_usage, what), format, bytes, what);
}

GpuTexels upload_texels_as(TexelsAs as, Device& device, std::span<const std::byte> data, VkFormat format,
                           std::string_view what) {
    if (as == TexelsAs::texels) return upload_texels(device, data, format, what);
    if (data.size() > device.limits().maxStorageBufferRange)
        throw DeviceError(fmt::format("{} need {} bytes, the device's storage buffers hold {}", what,
                                      data.size(), device.limits().maxStorageBufferRange));
    return {upload_buffer(device, data, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, what), {}};
}

void upload_image(Device& device, GpuImage& image, std::span<const std::byte> texels) {
    GpuBuffer staging =
        make_host_buffer(device, texels.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, "staging of an image");
    std::memcpy(staging.mapped, texels.data(), texels.size());
    std::vector<VkBufferImageCopy> regions;
    VkDeviceSize offset = 0;
    for (uint32_t level = 0; level < image.levels; ++level) {
        const uint32_t width = std::max(image.extent.width >> level, 1u);
        const uint32_t height = std::max(image.extent.height >> level, 1u);
        VkBufferImageCopy& region = regions.emplace_back();
        region.bufferOffset = offset;
        region.imageSubresource = {aspect_of(image.format), level, 0, 1};
        region.imageExtent = {width, height, 1};
        offset += VkDeviceSize(width) * height * texel_bytes(image.format);
    }
    if (offset != texels.size()) throw std::invalid_argument("upload_image: the levels do not fill the data");
    device.run([&](VkCommandBuffer commands) {
        full_barrier(commands, image.get(), image.format, VK_IMAGE_LAYOUT_UNDEFINED,
                     VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        vkCmdCopyBufferToImage(commands, staging.get(), image.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                               static_cast<uint32_t>(regions.size()), regions.data());
        full_barrier(commands, image.get(), image.format, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                     VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    });
}

std::vector<std::byte> read_image(Device& device, VkImage image, VkFormat format, VkExtent2D extent,
                                  VkImageLayout layout, uint32_t layer) {
    std::vector<std::byte> texels(size_t(extent.width) * extent.height * texel_bytes(format));
    GpuBuffer staging =
        make_host_buffer(device, texels.size(), VK_BUFFER_USAGE_TRANSFER_DST_BIT, "readback of an image");
    device.run([&](VkCommandBuffer commands) {
        full_barrier(commands, image, format, layout, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        VkBufferImageCopy region{};
        region.imageSubresource = {aspect_of(format), 0, layer, 1};
        region.imageExtent = {extent.width, extent.height, 1};
        vkCmdCopyImageToBuffer(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, staging.get(), 1,
                               &region);
        full_barrier(commands, image, format, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, layout);
        VkMemoryBarrier2 to_host{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
        to_host.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
        to_host.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
        to_host.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
        to_host.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
        VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
        dependency.memoryBarrierCount = 1;
        dependency.pMemoryBarriers = &to_host;
        vkCmdPipelineBarrier2(commands, &dependency);
    });
    std::memcpy(texels.data(), staging.mapped, texels.size());
    return texels;
}

}  // namespace penumbra
