// SPDX-License-Identifier: MIT
// Sizes are asked from the device before anything is created (vkGetDevice*MemoryRequirements, Vulkan 1.3), so
// that a plan for a device is final before its memory exists.
#include "graph/memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "graph/lifetimes.h"
#include "graph/limits.h"

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
    create.tiling = need.linear ? VK_IMAGE_TILING_LINEAR : VK_IMAGE_TILING_OPTIMAL;
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

// 0 where such an image cannot be had in linear tiling, or can do less.
uint64_t row_bytes(const GraphDevice& device, ImageNeed need) {
    need.linear = true;
    const VkImageCreateInfo create = image_info(need);
    const VkPhysicalDevice physical = device.handles().physical;
    VkFormatProperties can;
    device.vk().vkGetPhysicalDeviceFormatProperties(physical, create.format, &can);
    if ((can.linearTilingFeatures & can.optimalTilingFeatures) != can.optimalTilingFeatures) return 0;
    VkImageFormatProperties most;
    if (device.vk().vkGetPhysicalDeviceImageFormatProperties(physical, create.format, create.imageType,
                                                             create.tiling, create.usage, create.flags,
                                                             &most) != VK_SUCCESS ||
        most.maxExtent.width < need.extent.width || most.maxExtent.height < need.extent.height)
        return 0;
    VkImage image = VK_NULL_HANDLE;
    require(device.vk().vkCreateImage(device.get(), &create, nullptr, &image), "vkCreateImage", "row_bytes");
    const Held<VkImage> held{device, image};
    constexpr VkImageSubresource whole{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0};
    VkSubresourceLayout layout;
    device.vk().vkGetImageSubresourceLayout(device.get(), image, &whole, &layout);
    return layout.offset == 0 ? layout.rowPitch : 0;
}

// What is known of a driver beyond what Vulkan asks of it.
void add_habits(const DevicePtr& device_ptr, DeviceTable& table) {
    const GraphDevice& device = *device_ptr;
    VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
    VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES, &subgroup};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};
    device.vk().vkGetPhysicalDeviceProperties2(device.handles().physical, &properties);
    if (driver.driverID != VK_DRIVER_ID_MESA_LLVMPIPE) return;
    // Lavapipe calls a function for every access. What a fetch answers goes through memory, and its caller
    // waits for that; what a load answers stays in registers. Mesa 22 calls no functions, and fetches a tenth
    // faster. The version of the driver is 1 in all of them.
    int mesa = 0;
    table.loads_texels = std::sscanf(driver.driverInfo, "Mesa %d", &mesa) == 1 && mesa >= 25;
    // A subgroup is a vector of one thread; a barrier, of a subgroup too, makes a coroutine of it.
    table.lanes_in_step = subgroup.subgroupSize;
    // Eight texels that are stored take 50 to 240 ns, as words 8 to 45 (docs/performance.md).
    table.row_bytes = [device_ptr](const ImageNeed& need) { return row_bytes(*device_ptr, need); };
}

// What debuggers show: "color@1".
std::string object_name(const PlanResource& r, uint32_t parity) {
    return r.history ? fmt::format("{}@{}", r.names.back(), parity) : r.names.back();
}

}  // namespace

DeviceTable device_table(const DeviceHandles& handles) {
    const auto device = std::make_shared<const GraphDevice>(handles);
    const VkPhysicalDeviceProperties& properties = device->properties();
    DeviceTable table;
    table.name = properties.deviceName;
    table.cpu = properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    table.max_image_extent = properties.limits.maxImageDimension2D;
    table.max_texel_elements = properties.limits.maxTexelBufferElements;
    add_habits(device, table);
    table.max_storage_bytes = properties.limits.maxStorageBufferRange;
    table.limits = limits_of(handles.physical, device->vk());
    VkPhysicalDeviceMemoryProperties memory{};
    device->vk().vkGetPhysicalDeviceMemoryProperties(handles.physical, &memory);
    table.memory_bytes = 0;
    for (uint32_t heap = 0; heap < memory.memoryHeapCount; ++heap)
        if (memory.memoryHeaps[heap].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)  // as allocate_heap() asks for
            table.memory_bytes = std::max<uint64_t>(table.memory_bytes, memory.memoryHeaps[heap].size);
    const auto need_of = [](const VkMemoryRequirements2& answer) {
        return MemoryNeed{answer.memoryRequirements.size, answer.memoryRequirements.alignment,
                          answer.memoryRequirements.memoryTypeBits};
    };
    table.image_memory = [device, need_of](const ImageNeed& need) {
        const VkImageCreateInfo create = image_info(need);
        const VkDeviceImageMemoryRequirements ask{
            VK_STRUCTURE_TYPE_DEVICE_IMAGE_MEMORY_REQUIREMENTS, nullptr, &create, {}};
        VkMemoryRequirements2 answer{VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
        device->vk().vkGetDeviceImageMemoryRequirements(device->get(), &ask, &answer);
        return need_of(answer);
    };
    table.buffer_memory = [device, need_of](uint64_t bytes, VkBufferUsageFlags usage) {
        const VkBufferCreateInfo create = buffer_info(bytes, usage);
        const VkDeviceBufferMemoryRequirements ask{VK_STRUCTURE_TYPE_DEVICE_BUFFER_MEMORY_REQUIREMENTS,
                                                   nullptr, &create};
        VkMemoryRequirements2 answer{VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
        device->vk().vkGetDeviceBufferMemoryRequirements(device->get(), &ask, &answer);
        return need_of(answer);
    };
    table.supports = [device](Format format, VkFormatFeatureFlags features) {
        VkFormatProperties supported;
        device->vk().vkGetPhysicalDeviceFormatProperties(device->handles().physical, info(format).vk,
                                                         &supported);
        // Image and buffer features are different bits.
        return ((supported.optimalTilingFeatures | supported.bufferFeatures) & features) == features;
    };
    return table;
}

HeldMemory allocate_heap(const GraphDevice& device, const Heap& heap) {
    const std::string what = fmt::format("the {}heap of {}", heap.shared ? "shared " : "", heap.type);
    return HeldMemory(device,
                      {.need = {std::max<uint64_t>(heap.bytes, 1), heap.alignment, heap.memory_type_bits},
                       .properties = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
                       .linear = heap.type == "buffers",
                       .what = what.c_str()});
}

void check_device(const Plan& plan, const DeviceHandles& handles) {
    const DeviceTable device = device_table(handles);
    const auto refuse = [&](const std::string& why) {
        fail(ErrorCode::usage, plan.pipeline,
             fmt::format("the plan was compiled for the device \"{}\", and this is \"{}\"{}: compile it with "
                         "device_table(handles)",
                         plan.device, device.name, why));
    };
    if (plan.device != device.name) refuse("");
    for (const PlanResource& r : plan.resources) {
        if (r.slot) continue;  // the host's
        const MemoryNeed need = need_of(device, r);
        if (need.size > r.bytes || r.alignment % need.alignment != 0 ||
            need.type_bits != plan.heaps[r.heap].memory_type_bits)
            refuse(fmt::format(", which asks for other memory for \"{}\"", r.names.back()));
    }
}

namespace {

// A plan all of whose resources are kept shares none, and rightly.
void check_shares(const Plan& plan, const char* place) {
    for (const PlanResource& r : plan.resources)
        if (r.transient() && !plan.heaps[r.heap].shared)
            fail(ErrorCode::usage, place,
                 fmt::format("\"{}\" was compiled without CompileOptions::share_transients", plan.pipeline));
}

}  // namespace

// Of each kind of heap as much as the plan takes that takes most.
TransientMemory::TransientMemory(DevicePtr device, std::span<const Plan* const> plans)
    : device_(std::move(device)) {
    std::vector<Heap> heaps;
    for (const Plan* plan : plans) check_shares(*plan, "make_transients");
    for (const Plan* plan : plans)
        for (const Heap& heap : plan->heaps) {
            if (!heap.shared) continue;
            const auto same = std::ranges::find_if(heaps, [&](const Heap& h) {
                return h.type == heap.type && h.memory_type_bits == heap.memory_type_bits;
            });
            if (same == heaps.end()) {
                heaps.push_back(heap);
                continue;
            }
            same->bytes = std::max(same->bytes, heap.bytes);
            same->alignment = std::max(same->alignment, heap.alignment);  // powers of two
        }
    for (const Heap& heap : heaps) parts_.push_back({heap, allocate_heap(*device_, heap)});
}

const MemoryBlock& TransientMemory::heap(const Plan& plan, uint32_t index) const {
    const Heap& wanted = plan.heaps[index];
    for (const Part& part : parts_)
        if (part.heap.type == wanted.type && part.heap.memory_type_bits == wanted.memory_type_bits &&
            part.heap.bytes >= wanted.bytes && part.heap.alignment % wanted.alignment == 0)
            return part.memory.block();
    fail(ErrorCode::usage, "ViewOptions::transients",
         fmt::format("was made for another plan: it has no {} bytes for the shared heap of {} of \"{}\"",
                     wanted.bytes, wanted.type, plan.pipeline));
}

uint64_t TransientMemory::bytes() const {
    uint64_t sum = 0;
    for (const Part& part : parts_) sum += part.memory.bytes();
    return sum;
}

PlanMemory::PlanMemory(const GraphDevice& device, const Plan& plan,
                       std::shared_ptr<const TransientMemory> transients)
    : device_(device), transients_(std::move(transients)), instances_(plan.resources.size()) {
    if (transients_ && transients_->device().get() != device.get())
        fail(ErrorCode::usage, "ViewOptions::transients", "was made on another device");
    if (transients_) check_shares(plan, "ViewOptions::transients");
    std::vector<const MemoryBlock*> blocks;
    heaps_.resize(plan.heaps.size());
    for (uint32_t h = 0; h < plan.heaps.size(); ++h) {
        const bool shared = transients_ && plan.heaps[h].shared;
        if (!shared) heaps_[h] = allocate_heap(device, plan.heaps[h]);
        blocks.push_back(shared ? &transients_->heap(plan, h) : &heaps_[h].block());
    }
    for (uint32_t i = 0; i < plan.resources.size(); ++i) {
        const PlanResource& r = plan.resources[i];
        kept_.push_back(r.kept);
        if (r.slot) continue;  // the host's
        for (uint32_t parity = 0; parity < (r.kept ? 1u : 2u); ++parity) {
            Instance& instance = instances_[i][parity];
            if (r.kind == PortKind::image)
                make_image(r, *blocks[r.heap], parity, instance);
            else
                make_buffer(r, *blocks[r.heap], parity, instance);
            instance.handles = {instance.image.get(), instance.image_view.get(), instance.buffer.get(),
                                instance.buffer_view.get(), instance.handles.bytes};
        }
    }
}

VkImageView PlanMemory::level(uint32_t resource, uint32_t parity, uint32_t level) const {
    const auto& views = instances_[resource][kept_[resource] ? 0 : parity].level_views;
    return views.empty() ? VK_NULL_HANDLE : views[level].get();
}

VkBuffer PlanMemory::rows(uint32_t resource, uint32_t parity) const {
    return instances_[resource][kept_[resource] ? 0 : parity].rows.get();
}

uint64_t PlanMemory::bytes() const {
    uint64_t sum = 0;
    for (const HeldMemory& heap : heaps_) sum += heap.bytes();
    return sum;
}

Held<VkImageView> PlanMemory::image_view(const PlanResource& r, VkImage image, uint32_t first_level,
                                         uint32_t levels) const {
    VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view.image = image;
    view.viewType = r.layered ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    view.format = info(r.format).vk;
    view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, first_level, levels, 0, r.layers};
    VkImageView handle = VK_NULL_HANDLE;
    require(device_.vk().vkCreateImageView(device_.get(), &view, nullptr, &handle), "vkCreateImageView",
            r.names.front());
    return {device_, handle};
}

void PlanMemory::make_image(const PlanResource& r, const MemoryBlock& heap, uint32_t parity,
                            Instance& out) const {
    const std::string& name = r.names.front();
    const VkImageCreateInfo create =
        image_info({r.format, r.extent, r.layers, r.levels, r.image_usage, r.row_bytes != 0});
    VkImage image = VK_NULL_HANDLE;
    require(device_.vk().vkCreateImage(device_.get(), &create, nullptr, &image), "vkCreateImage", name);
    out.image = {device_, image};
    device_.name(VK_OBJECT_TYPE_IMAGE, image, object_name(r, parity));
    require(device_.vk().vkBindImageMemory(device_.get(), image, heap.memory, heap.offset + r.offset[parity]),
            "vkBindImageMemory", name);
    out.image_view = image_view(r, image, 0, r.levels);
    for (uint32_t level = 0; level < r.levels && r.levels > 1; ++level)
        out.level_views.push_back(image_view(r, image, level, 1));
    if (r.row_bytes) out.rows = buffer(r, heap, parity, rows_usage);
}

Held<VkBuffer> PlanMemory::buffer(const PlanResource& r, const MemoryBlock& heap, uint32_t parity,
                                  VkBufferUsageFlags usage) const {
    const std::string& name = r.names.front();
    const VkBufferCreateInfo create = buffer_info(r.buffer_bytes(), usage);
    VkBuffer handle = VK_NULL_HANDLE;
    require(device_.vk().vkCreateBuffer(device_.get(), &create, nullptr, &handle), "vkCreateBuffer", name);
    Held<VkBuffer> held{device_, handle};
    device_.name(VK_OBJECT_TYPE_BUFFER, handle, object_name(r, parity));
    require(
        device_.vk().vkBindBufferMemory(device_.get(), handle, heap.memory, heap.offset + r.offset[parity]),
        "vkBindBufferMemory", name);
    return held;
}

void PlanMemory::make_buffer(const PlanResource& r, const MemoryBlock& heap, uint32_t parity,
                             Instance& out) const {
    const std::string& name = r.names.front();
    out.buffer = buffer(r, heap, parity, r.buffer_usage);
    out.handles.bytes = r.buffer_bytes();
    if (!(r.buffer_usage & VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT)) return;
    VkBufferViewCreateInfo view{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
    view.buffer = out.buffer.get();
    view.format = info(r.format).vk;
    view.range = VK_WHOLE_SIZE;
    VkBufferView handle = VK_NULL_HANDLE;
    require(device_.vk().vkCreateBufferView(device_.get(), &view, nullptr, &handle), "vkCreateBufferView",
            name);
    out.buffer_view = {device_, handle};
}

}  // namespace penumbra
