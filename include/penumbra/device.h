// SPDX-License-Identifier: MIT
// The host's device, as penumbra sees it: handles, the way to Vulkan's functions, and where memory comes
// from. Penumbra creates no instance, device or queue, links no loader, submits nothing and waits for
// nothing.
#pragma once

#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <functional>

#include "penumbra/export.h"
#include "penumbra/plan.h"

namespace penumbra PENUMBRA_API {

struct MemoryRequest {
    VkMemoryRequirements need{};           // bytes, alignment, types
    VkMemoryPropertyFlags properties = 0;  // that the type must have
    bool mapped = false;                   // MemoryBlock::mapped is to be filled in, for the block's lifetime
    bool linear = false;                   // holds buffers, or images whose memory is a buffer's, too; else
                                           // images of optimal tiling
    bool readback = false;                 // the host reads it: a type that is HOST_CACHED, too, is best
    const char* what = "";                 // to print
};

// A part of an allocation. It begins at `offset`, which the request's alignment divides.
struct MemoryBlock {
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkDeviceSize offset = 0;
    void* mapped = nullptr;  // where the block begins
    void* user = nullptr;    // the host's own
};

// The host's allocator; empty functions: vkAllocateMemory, once per request. Called on any thread that
// makes or destroys a program, transients or a view (shared ones: by their last owner), never while a
// frame is recorded. A failure is reported as ErrorCode::out_of_memory, with its VkResult.
struct HostMemory {
    std::function<VkResult(const MemoryRequest&, MemoryBlock&)> allocate;
    std::function<void(const MemoryBlock&)> release;
};

struct DeviceHandles {
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    uint32_t queue_family = 0;  // that frames are submitted to
    // The loader's, or what stands for it: every function is asked of this.
    PFN_vkGetInstanceProcAddr get_instance_proc_addr = nullptr;
    HostMemory memory;
    // Whether VK_EXT_debug_utils is enabled: then objects have names and passes labels, for debuggers. Its
    // functions can be had without, from whatever layers are there, which then object to every call.
    bool debug_utils = false;
};

// Limits, format features and memory sizes of a real device, which must outlive the table. Which features are
// enabled cannot be asked of a device: the caller fills them in.
DeviceTable device_table(const DeviceHandles& handles);

}  // namespace penumbra
