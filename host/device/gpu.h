// SPDX-License-Identifier: MIT
// Buffers and images with memory of their own, uploads and readbacks: the host's few static resources and the
// tests' eyes. One allocation each; what is per frame and plentiful belongs to the graph's packed heaps
// instead.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "host/device/device.h"

namespace penumbra {

struct GpuBuffer {
    Owned<VkDeviceMemory> memory;
    Owned<VkBuffer> buffer;  // declared after its memory, so destroyed before it
    VkDeviceSize bytes = 0;
    void* mapped = nullptr;  // host-visible buffers stay mapped

    VkBuffer get() const { return buffer.get(); }
};

// What a uniform texel buffer reads: `texels` elements of one format.
struct GpuTexels {
    GpuBuffer buffer;
    Owned<VkBufferView> view;  // declared after its buffer, so destroyed before it
};

struct GpuImage {
    Owned<VkDeviceMemory> memory;
    Owned<VkImage> image;
    Owned<VkImageView> view;
    VkFormat format = VK_FORMAT_UNDEFINED;
    VkExtent2D extent{};
    uint32_t levels = 1, layers = 1;

    VkImage get() const { return image.get(); }
};

// `what` names the object in errors. `bytes` > 0.
GpuBuffer make_device_buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage,
                             std::string_view what);
// Host-visible, coherent, mapped; where commands copy into it (TRANSFER_DST), in memory that is quick to
// read.
GpuBuffer make_host_buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage,
                           std::string_view what);
// 2D, one layer, optimal tiling.
GpuImage make_image(const Device& device, VkFormat format, VkExtent2D extent, uint32_t levels,
                    VkImageUsageFlags usage, std::string_view what);
// The same with layers, one level; its view is of an array, also of one layer.
GpuImage make_layered_image(const Device& device, VkFormat format, VkExtent2D extent, uint32_t layers,
                            VkImageUsageFlags usage, std::string_view what);
// A view of one layer, to render to.
Owned<VkImageView> make_layer_view(const Device& device, const GpuImage& image, uint32_t layer);

// A device buffer filled with `data` (at least 16 bytes are allocated, so that empty data has a buffer too).
GpuBuffer upload_buffer(Device& device, std::span<const std::byte> data, VkBufferUsageFlags usage,
                        std::string_view what);
// Writes some elements of so many bytes anew, by their numbers, ascending, into a buffer that was filled with
// as much data.
void update_buffer(Device& device, const GpuBuffer& buffer, std::span<const std::byte> data,
                   size_t element_bytes, std::span<const uint32_t> elements, std::string_view what);
// At least one texel; throws DeviceError, which names `what`, where the device's texel buffers hold fewer.
GpuTexels upload_texels(Device& device, std::span<const std::byte> data, VkFormat format,
                        std::string_view what);
// Host-visible, coherent, mapped.
GpuTexels make_host_texels(const Device& device, VkDeviceSize bytes, VkFormat format, std::string_view what);
// What a plan asks for as texels, or, for a device whose texel buffers are small, as a storage buffer of the
// same words (then without a view); throws DeviceError where neither holds as much.
enum class TexelsAs : uint8_t { texels, words };
GpuTexels upload_texels_as(TexelsAs as, Device& device, std::span<const std::byte> data, VkFormat format,
                           std::string_view what);
// Fills all levels, tightly packed one after the other; leaves the image in SHADER_READ_ONLY_OPTIMAL.
void upload_image(Device& device, GpuImage& image, std::span<const std::byte> texels);

// One layer's texels of level 0, rows tightly packed. The image (TRANSFER_SRC usage) is in `layout`, and is
// left in it.
std::vector<std::byte> read_image(Device& device, VkImage image, VkFormat format, VkExtent2D extent,
                                  VkImageLayout layout, uint32_t layer = 0);

// Everything before, then everything after: blocking transfers need no finer scopes.
void full_barrier(VkCommandBuffer commands, VkImage image, VkFormat format, VkImageLayout from,
                  VkImageLayout to);

// Bytes per texel of the formats that the host creates and the graph hands out; throws on others.
uint32_t texel_bytes(VkFormat format);
bool is_depth(VkFormat format);

}  // namespace penumbra
