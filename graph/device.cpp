// SPDX-License-Identifier: MIT
#include "graph/device.h"

#include <fmt/format.h>

#include "graph/memory_type.h"

namespace penumbra {

std::string result_name(VkResult result) {
    switch (result) {
        case VK_SUCCESS:
            return "VK_SUCCESS";
        case VK_ERROR_OUT_OF_HOST_MEMORY:
            return "VK_ERROR_OUT_OF_HOST_MEMORY";
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
            return "VK_ERROR_OUT_OF_DEVICE_MEMORY";
        case VK_ERROR_INITIALIZATION_FAILED:
            return "VK_ERROR_INITIALIZATION_FAILED";
        case VK_ERROR_DEVICE_LOST:
            return "VK_ERROR_DEVICE_LOST";
        case VK_ERROR_MEMORY_MAP_FAILED:
            return "VK_ERROR_MEMORY_MAP_FAILED";
        case VK_ERROR_LAYER_NOT_PRESENT:
            return "VK_ERROR_LAYER_NOT_PRESENT";
        case VK_ERROR_EXTENSION_NOT_PRESENT:
            return "VK_ERROR_EXTENSION_NOT_PRESENT";
        case VK_ERROR_FEATURE_NOT_PRESENT:
            return "VK_ERROR_FEATURE_NOT_PRESENT";
        case VK_ERROR_INCOMPATIBLE_DRIVER:
            return "VK_ERROR_INCOMPATIBLE_DRIVER";
        case VK_ERROR_TOO_MANY_OBJECTS:
            return "VK_ERROR_TOO_MANY_OBJECTS";
        case VK_ERROR_FORMAT_NOT_SUPPORTED:
            return "VK_ERROR_FORMAT_NOT_SUPPORTED";
        case VK_ERROR_FRAGMENTED_POOL:
            return "VK_ERROR_FRAGMENTED_POOL";
        case VK_ERROR_OUT_OF_POOL_MEMORY:
            return "VK_ERROR_OUT_OF_POOL_MEMORY";
        case VK_ERROR_INVALID_OPAQUE_CAPTURE_ADDRESS:
            return "VK_ERROR_INVALID_OPAQUE_CAPTURE_ADDRESS";
        case VK_TIMEOUT:
            return "VK_TIMEOUT";
        case VK_NOT_READY:
            return "VK_NOT_READY";
        case VK_INCOMPLETE:
            return "VK_INCOMPLETE";
        default:
            return "VkResult " + std::to_string(static_cast<int>(result));
    }
}

std::string to_string(const Error& error) {
    return error.place.empty() ? error.text : error.place + ": " + error.text;
}

Failure::Failure(Error error) : error_(std::move(error)), text_(to_string(error_)) {}

void fail(ErrorCode code, std::string place, std::string text) {
    throw Failure({code, std::move(place), std::move(text), VK_SUCCESS});
}

void require(VkResult result, const char* call, const std::string& what) {
    if (result == VK_SUCCESS) return;
    const ErrorCode code = result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY ||
                                   result == VK_ERROR_OUT_OF_POOL_MEMORY
                               ? ErrorCode::out_of_memory
                           : result == VK_ERROR_DEVICE_LOST ? ErrorCode::device_lost
                                                            : ErrorCode::vulkan;
    throw Failure({code, what, fmt::format("{} failed with {}", call, result_name(result)), result});
}

namespace {

void check_physical(const DeviceHandles& handles) {
    const auto given = [](bool there, const char* member) {
        if (!there) fail(ErrorCode::usage, fmt::format("DeviceHandles::{}", member), "is null");
    };
    given(handles.instance != VK_NULL_HANDLE, "instance");
    given(handles.physical != VK_NULL_HANDLE, "physical");
    given(handles.get_instance_proc_addr != nullptr, "get_instance_proc_addr");
}

template <class Function>
Function loaded(PFN_vkVoidFunction function, const char* name) {
    if (!function)
        fail(
            ErrorCode::usage, name,
            "DeviceHandles::get_instance_proc_addr does not give it (is VkApplicationInfo::apiVersion of the "
            "instance 1.3?)");
    return reinterpret_cast<Function>(function);
}

}  // namespace

VulkanFunctions instance_functions(const DeviceHandles& handles) {
    check_physical(handles);
    VulkanFunctions vk;
#define PENUMBRA_LOAD(name) \
    vk.name = loaded<PFN_##name>(handles.get_instance_proc_addr(handles.instance, #name), #name);
    PENUMBRA_INSTANCE_FUNCTIONS(PENUMBRA_LOAD)
#undef PENUMBRA_LOAD
    return vk;
}

GraphDevice::GraphDevice(const DeviceHandles& handles) : handles_(handles), vk_(instance_functions(handles)) {
    if (handles.device == VK_NULL_HANDLE) fail(ErrorCode::usage, "DeviceHandles::device", "is null");
    if (!handles.memory.allocate != !handles.memory.release)
        fail(ErrorCode::usage, "DeviceHandles::memory", "has one of its two functions");
    // First of all the version: an older device does not have the functions.
    vk_.vkGetPhysicalDeviceProperties(handles.physical, &properties_);
    if (properties_.apiVersion < VK_API_VERSION_1_3)
        fail(ErrorCode::unsupported, properties_.deviceName,
             fmt::format("has Vulkan {}.{}, of which 1.3 is needed",
                         VK_API_VERSION_MAJOR(properties_.apiVersion),
                         VK_API_VERSION_MINOR(properties_.apiVersion)));
#define PENUMBRA_LOAD(name) \
    vk_.name = loaded<PFN_##name>(vk_.vkGetDeviceProcAddr(handles.device, #name), #name);
    PENUMBRA_DEVICE_FUNCTIONS(PENUMBRA_LOAD)
#undef PENUMBRA_LOAD
    if (handles.debug_utils) {
#define PENUMBRA_LOAD(name) \
    vk_.name = reinterpret_cast<PFN_##name>(vk_.vkGetDeviceProcAddr(handles.device, #name));
        PENUMBRA_DEBUG_FUNCTIONS(PENUMBRA_LOAD)
#undef PENUMBRA_LOAD
    }
    vk_.vkGetPhysicalDeviceMemoryProperties(handles.physical, &memory_);
    uint32_t families = 0;
    vk_.vkGetPhysicalDeviceQueueFamilyProperties(handles.physical, &families, nullptr);
    queue_families_.resize(families);
    vk_.vkGetPhysicalDeviceQueueFamilyProperties(handles.physical, &families, queue_families_.data());
    if (handles.queue_family >= families)
        fail(ErrorCode::usage, "DeviceHandles::queue_family",
             fmt::format("is {}, of {} families", handles.queue_family, families));
}

MemoryBlock GraphDevice::allocate(const MemoryRequest& request) const {
    MemoryBlock block;
    if (handles_.memory.allocate) {
        const VkResult result = handles_.memory.allocate(request, block);
        const auto refuse = [&](const char* text) { fail(ErrorCode::usage, request.what, text); };
        if (result != VK_SUCCESS)
            throw Failure({ErrorCode::out_of_memory, request.what,
                           fmt::format("the host's allocator gave no {} bytes: {}", request.need.size,
                                       result_name(result)),
                           result});
        // From here on the block is the host's to take back.
        try {
            if (block.memory == VK_NULL_HANDLE) refuse("the host's allocator gave no memory, and no error");
            if (block.offset % request.need.alignment)
                refuse("the host's allocator gave an offset that is not aligned");
            if (request.mapped && !block.mapped)
                refuse("the host's allocator gave memory that is not mapped");
        } catch (...) {
            handles_.memory.release(block);
            throw;
        }
        return block;
    }
    const uint32_t allowed = request.need.memoryTypeBits;
    const auto type = memory_type(memory_, allowed, request.properties, request.readback);
    if (!type)
        fail(ErrorCode::unsupported, request.what,
             fmt::format("no memory type of {:#x} has the properties {:#x}", allowed, request.properties));
    const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, request.need.size,
                                    *type};
    const std::string what = fmt::format("{}, {} bytes", request.what, request.need.size);
    require(vk_.vkAllocateMemory(get(), &info, nullptr, &block.memory), "vkAllocateMemory", what);
    if (request.mapped)
        if (const VkResult result =
                vk_.vkMapMemory(get(), block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped)) {
            vk_.vkFreeMemory(get(), block.memory, nullptr);
            require(result, "vkMapMemory", what);
        }
    return block;
}

void GraphDevice::release(const MemoryBlock& block) const {
    if (handles_.memory.release)
        handles_.memory.release(block);
    else
        vk_.vkFreeMemory(get(), block.memory, nullptr);
}

void GraphDevice::set_name(VkObjectType type, uint64_t handle, const std::string& text) const {
    if (!vk_.vkSetDebugUtilsObjectNameEXT) return;
    VkDebugUtilsObjectNameInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT};
    info.objectType = type;
    info.objectHandle = handle;
    info.pObjectName = text.c_str();
    vk_.vkSetDebugUtilsObjectNameEXT(get(), &info);  // nothing depends on a name
}

MappedBuffer::MappedBuffer(const GraphDevice& device, VkDeviceSize bytes, VkBufferUsageFlags usage,
                           const std::string& what)
    : size_(bytes) {
    VkBufferCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    create.size = bytes;
    create.usage = usage;
    VkBuffer buffer = VK_NULL_HANDLE;
    require(device.vk().vkCreateBuffer(device.get(), &create, nullptr, &buffer), "vkCreateBuffer", what);
    buffer_ = {device, buffer};
    device.name(VK_OBJECT_TYPE_BUFFER, buffer, what);
    MemoryRequest request{
        .properties = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
        .mapped = true,
        .linear = true,
        .readback = (usage & VK_BUFFER_USAGE_TRANSFER_DST_BIT) != 0,
        .what = what.c_str()};
    device.vk().vkGetBufferMemoryRequirements(device.get(), buffer, &request.need);
    memory_ = HeldMemory(device, request);
    require(
        device.vk().vkBindBufferMemory(device.get(), buffer, memory_.block().memory, memory_.block().offset),
        "vkBindBufferMemory", what);
}

}  // namespace penumbra
